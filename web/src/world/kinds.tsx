/** Broad categories of elements, each with an icon. */

import {
  IconBolt,
  IconBox,
  IconCamera,
  IconCube,
  IconHandGrab,
  IconMapPin,
  IconPackage,
  IconQuestionMark,
  IconRobot,
  IconRoute,
  IconSchool,
  IconSettings2,
  IconStack2,
  IconTable,
  type TablerIcon,
} from "@tabler/icons-react";
import { createElement } from "react";
import { ancestors, type Classes, useClasses } from "./classes";

const ICONS: Readonly<Record<string, TablerIcon>> = {
  "sk:Robot": IconRobot,
  "sk:Camera": IconCamera,
  "sk:Gripper": IconHandGrab,
  "sk:Device": IconSettings2,
  "sk:Agent": IconRoute,
  "sk:Module": IconBolt,
  "sk:Manipulatable": IconCube,
  "sk:Furniture": IconTable,
  "sk:Container": IconBox,
  "sk:Surface": IconTable,
  "sk:UnknownLocation": IconQuestionMark,
  "sk:Location": IconMapPin,
  "sk:Stock": IconStack2,
  "sk:TaughtPose": IconSchool,
  "sk:LearnedDuration": IconSchool,
};

/** The icon of a class, hidden from screen readers, since its name is next to it. */
export function KindIcon({ class_ }: { class_: string }) {
  const icon = iconOf(useClasses(), class_);
  return createElement(icon, { size: 15, "aria-hidden": true, style: STYLE });
}

const STYLE = { flex: "none", color: "var(--mantine-color-dimmed)" } as const;

/** Returns the icon of a class or its nearest ancestor with one. */
function iconOf(classes: Classes, name: string): TablerIcon {
  for (const one of ancestors(classes, name)) {
    const icon = ICONS[one];
    if (icon !== undefined) return icon;
  }
  return IconPackage;
}
