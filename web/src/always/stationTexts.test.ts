import type { StationState } from "../live/station";
import { clock, movingRobots, windowTitle } from "./stationTexts";

const WORDS = { lost: "no connection", asks: "a question", halted: "halted", running: "running" };

function state(change: Partial<StationState>): StationState {
  const base = { pose: { position: [0, 0, 0], orientation: [0, 0, 0, 1] }, linear: 0, angular: 0, still: true };
  const arm = { positions: [], velocities: [], still: true, tool: null };
  return {
    ...{ time: 0, cycle: 0, pace: 1, halted: "", standing: true, grippers: {}, modules: [], tasks: [] },
    ...{ looks: {}, motions: {}, arms: { arm_1: arm, arm_2: arm }, bases: { base_1: base, base_2: base } },
    ...change,
  } as StationState;
}

const ROBOTS = [1, 2].map((n) => ({
  id: `robot_${n}`,
  label: n === 1 ? "Anna" : "",
  base: { id: `base_${n}` },
  arms: [{ id: `arm_${n}` }],
  grippers: [],
}));

test.each([
  [5, "0:05"],
  [75, "1:15"],
  [3675, "1:01:15"],
])("%d seconds are %s", (seconds, text) => {
  expect(clock(seconds)).toBe(text);
});

test("a robot moves when any part of it does, and is called by its label", () => {
  const moving = state({});
  moving.arms["arm_1"] = { positions: [], velocities: [], still: false, tool: null };
  expect(movingRobots(moving, ROBOTS)).toBe("Anna");
  moving.arms["arm_2"] = { positions: [], velocities: [], still: false, tool: null };
  expect(movingRobots(moving, ROBOTS)).toBe("Anna, robot_2");
  expect(movingRobots(state({}), ROBOTS)).toBe("");
});

test("the window's title says what matters most", () => {
  const running = state({ tasks: [{ name: "kit-17", status: "running" }] });
  expect(windowTitle(running, false, 0, WORDS)).toBe("● kit-17 running – skiros");
  expect(windowTitle({ ...running, halted: "why" }, false, 0, WORDS)).toBe("■ halted – skiros");
  expect(windowTitle(running, false, 1, WORDS)).toBe("? a question – skiros");
  expect(windowTitle(running, true, 1, WORDS)).toBe("⚠ no connection – skiros");
  expect(windowTitle(null, false, 0, WORDS)).toBe("skiros");
});
