import type { TFunction } from "i18next";
import type { ReactNode } from "react";
import type { Device } from "../../api/cell";
import { BaseJog } from "./BaseJog";
import { GripperJog } from "./GripperJog";
import { Joints } from "./Joints";
import { ModuleForm } from "./ModuleForm";
import { ToolJog } from "./ToolJog";

interface Moved {
  device: Device;
  disabled: boolean;
  t: TFunction<"modules">;
}

export interface Panel {
  value: string;
  title: string;
  /** Id of the jogged device. */
  device: string;
  content: ReactNode;
}

type Made = { title: string; content: ReactNode } | null;

/** Panels with buttons and sliders, by the module that they start; null if the panel does not fit the device. */
const PANELS: Readonly<Record<string, (moved: Moved) => Made>> = {
  jog_joints: ({ device, disabled, t }) =>
    device.joints.length > 0 && device.robot !== null
      ? {
          title: t("jog.joints", { arm: device.id }),
          content: <Joints device={device} robot={device.robot} disabled={disabled} />,
        }
      : null,
  jog_tool: ({ device: { id }, disabled, t }) => ({
    title: t("jog.tool", { arm: id }),
    content: <ToolJog arm={id} disabled={disabled} />,
  }),
  gripper_control: ({ device: { id, description }, disabled, t }) =>
    typeof description["max_gap"] === "number"
      ? {
          title: t("jog.gripper", { gripper: id }),
          content: <GripperJog gripper={id} maxGap={description["max_gap"]} disabled={disabled} />,
        }
      : null,
  jog_base: ({ device: { id }, disabled, t }) => ({
    title: t("jog.base", { base: id }),
    content: <BaseJog base={id} disabled={disabled} />,
  }),
};

/** The module that moves a device home: it has its own button. */
export const HOME = "home";

/** Returns the panels of a device: for a module without a panel, its form. */
export function panelsOf(moved: Moved): Panel[] {
  const { device, disabled, t } = moved;
  return device.jog
    .filter(({ module }) => module !== HOME)
    .map((module) => ({
      value: `${module.module} ${device.id}`,
      device: device.id,
      ...(PANELS[module.module]?.(moved) ?? {
        title: t("jog.device", { kind: device.kind, id: device.id }),
        content: <ModuleForm device={device} module={module} verb="jog" disabled={disabled} />,
      }),
    }));
}
