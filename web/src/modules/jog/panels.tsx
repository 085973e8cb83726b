import type { TFunction } from "i18next";
import type { ReactNode } from "react";
import type { Device, Robot } from "../queries";
import { BaseJog } from "./BaseJog";
import { GripperJog } from "./GripperJog";
import { Joints } from "./Joints";
import { ModuleForm } from "./ModuleForm";
import { ToolJog } from "./ToolJog";

interface Moved {
  device: Device;
  robot: Robot;
  disabled: boolean;
  t: TFunction<"modules">;
}

export interface Panel {
  value: string;
  title: string;
  /** Id of the device that it moves. */
  device: string;
  content: ReactNode;
}

/** Panels with buttons and sliders, by the module that a kind of device names for jogging. */
const PANELS: Readonly<Record<string, (moved: Moved) => Panel[]>> = {
  jog_joints: ({ device: { id }, robot, disabled, t }) =>
    robot.arms
      .filter((arm) => arm.id === id)
      .flatMap((arm) => [
        {
          value: `joints ${id}`,
          title: t("jog.joints", { arm: id }),
          device: id,
          content: <Joints robot={robot.id} arm={arm} disabled={disabled} />,
        },
        {
          value: `tool ${id}`,
          title: t("jog.tool", { arm: id }),
          device: id,
          content: <ToolJog robot={robot.id} arm={id} disabled={disabled} />,
        },
      ]),
  gripper_control: ({ device: { id }, robot, disabled, t }) =>
    robot.grippers
      .filter((gripper) => gripper.id === id)
      .map((gripper) => ({
        value: id,
        title: t("jog.gripper", { gripper: id }),
        device: id,
        content: <GripperJog robot={robot.id} gripper={gripper} disabled={disabled} />,
      })),
  jog_base: ({ device: { id }, robot, disabled, t }) =>
    robot.base?.id === id
      ? [
          {
            value: "base",
            title: t("jog.base", { base: id }),
            device: id,
            content: <BaseJog robot={robot.id} base={id} disabled={disabled} />,
          },
        ]
      : [],
};

/** Returns the panels that move a device: where there is none for its module, the form of that module. */
export function panelsOf(moved: Moved): Panel[] {
  const { device, disabled, t } = moved;
  const { id, kind, jog } = device;
  if (jog === "") return [];
  const panels = PANELS[jog]?.(moved) ?? [];
  if (panels.length > 0) return panels;
  const content = <ModuleForm device={device} module={jog} disabled={disabled} />;
  return [{ value: id, title: t("jog.device", { kind, id }), device: id, content }];
}
