import type { TFunction } from "i18next";
import type { Device } from "../../api/cell";
import { panelsOf } from "./panels";

const JOINT = { name: "shoulder", lower: null, upper: null, velocity: null };
const t = ((key: string) => key) as TFunction<"modules">;

function device(modules: string[], more: Partial<Device> = {}): Device {
  const jog = modules.map((module) => ({ module, agent: "arm_1" }));
  const empty = {
    description: {},
    signals: [],
    joints: [],
    frames: [],
    mounted_on: "",
    model: "",
    place: null,
    open: true,
    commanded: true,
    teach: [],
  };
  return { id: "device_1", kind: "turntable", robot: "robot_1", jog, ...empty, ...more };
}

function titles(one: Device): string[] {
  return panelsOf({ device: one, disabled: false, t }).map(({ title }) => title);
}

test("the jog modules that a kind names determine the panels of a device", () => {
  expect(titles(device(["jog_joints", "jog_tool", "home"], { joints: [JOINT] }))).toEqual(["jog.joints", "jog.tool"]);
  expect(titles(device(["gripper_control"], { description: { max_gap: 0.08 } }))).toEqual(["jog.gripper"]);
  expect(titles(device(["jog_base"], { kind: "omni" }))).toEqual(["jog.base"]);
  expect(titles(device([]))).toEqual([]);
});

test("a module without a panel, or with a panel that does not fit the device, has a form", () => {
  expect(titles(device(["turn_table"]))).toEqual(["jog.device"]);
  expect(titles(device(["gripper_control"]))).toEqual(["jog.device"]); // it has no maximum gap
});
