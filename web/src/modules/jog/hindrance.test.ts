import type { StationState } from "../../live/station";
import type { RobotInfo as Robot } from "../../api/cell";
import { hindranceOf } from "./hindrance";

const ROBOT = { id: "robot_1", agents: ["arm_1", "base_1"] } as unknown as Robot;
const state = (part: Partial<StationState>) =>
  ({ halted: "", modules: [], tasks: [], ...part }) as unknown as StationState;
const running = (agent: string, status = "running") => [{ agent, module: "pick", status }];

test("a robot at rest can be jogged, one without a known state or one that is halted cannot", () => {
  expect(hindranceOf(state({}), ROBOT, false, true)).toBeNull();
  expect(hindranceOf(null, ROBOT, false, true)).toEqual({ why: "unknown" });
  expect(hindranceOf(state({ halted: "stop-all" }), ROBOT, true, true)).toEqual({ why: "halted", text: "stop-all" });
});

test("modules running on this robot prevent jogging, except jog steps; those on other robots do not", () => {
  const busy = state({ modules: running("arm_1") });
  expect(hindranceOf(busy, ROBOT, false, true)).toEqual({ why: "atWork", modules: ["pick (arm_1)"] });
  expect(hindranceOf(busy, ROBOT, true, true)).toBeNull();
  expect(hindranceOf(state({ modules: running("arm_9") }), ROBOT, false, true)).toBeNull();
  expect(hindranceOf(state({ modules: running("arm_1", "ended") }), ROBOT, false, true)).toBeNull();
});

test("for paused work the text proposes neither waiting nor pausing", () => {
  const paused = state({ modules: running("arm_1", "paused") });
  expect(hindranceOf(paused, ROBOT, false, true)).toEqual({ why: "paused", modules: ["pick (arm_1)"] });
  const also = state({ modules: [...running("arm_1", "paused"), ...running("base_1")] });
  expect(hindranceOf(also, ROBOT, false, true)).toMatchObject({ why: "atWork" });
});

test("a running task prevents jogging of the only robot; a paused or waiting task does not", () => {
  const at = (status: string) => state({ tasks: [{ name: "kit-17", status }] });
  expect(hindranceOf(at("running"), ROBOT, false, true)).toEqual({ why: "task", tasks: ["kit-17"] });
  expect(hindranceOf(at("running"), ROBOT, false, false)).toBeNull();
  expect(hindranceOf(at("paused"), ROBOT, false, true)).toBeNull();
  expect(hindranceOf(at("waiting"), ROBOT, false, true)).toBeNull();
});
