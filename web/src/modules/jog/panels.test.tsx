import type { TFunction } from "i18next";
import type { Device, Robot, Summary } from "../queries";
import { agentFor } from "../devices/agents";
import { panelsOf } from "./panels";

const ARM = { id: "arm_1", joints: [], home: [], tip: "tcp" };
const ROBOT = { id: "robot_1", arms: [ARM], grippers: [], base: null } as unknown as Robot;
const t = ((key: string) => key) as TFunction<"modules">;

function device(id: string, jog: string, robot: string | null = "robot_1"): Device {
  const empty = { description: {}, signals: [], open: true, commanded: true, teach: "" };
  return { id, kind: "turntable", robot, jog, ...empty };
}

function titles(one: Device): string[] {
  return panelsOf({ device: one, robot: ROBOT, disabled: false, t }).map(({ title }) => title);
}

test("the module that a kind names says which panels move a device", () => {
  expect(titles(device("arm_1", "jog_joints"))).toEqual(["jog.joints", "jog.tool"]);
  expect(titles(device("camera_1", ""))).toEqual([]);
});

test("a device of an unknown kind gets the form of the module that its kind names", () => {
  expect(titles(device("table_1", "turn_table"))).toEqual(["jog.device"]);
  expect(titles(device("hand_1", "gripper_control"))).toEqual(["jog.device"]); // not one of the robot's grippers
});

test("a module of a device runs at its own subsystem, else at one of its robot", () => {
  const places = (...agents: string[]) => agents.map((agent) => ({ agent, robot: `robot_${agent.at(-1)}` }));
  const modules = [{ name: "turn_table", agents: places("arm_2", "arm_1", "table_1") }] as Summary[];
  expect(agentFor(modules, "turn_table", device("table_1", "turn_table"))).toBe("table_1");
  expect(agentFor(modules, "turn_table", device("table_9", "turn_table"))).toBe("arm_1");
  expect(agentFor(modules, "turn_table", device("table_9", "turn_table", "robot_7"))).toBeUndefined();
  expect(agentFor(modules, "turn_table", device("table_9", "turn_table", null))).toBe("arm_2");
});
