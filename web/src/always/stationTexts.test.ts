import type { StationState } from "../live/station";
import { clock, movingRobots, windowTitle } from "./stationTexts";

const WORDS = { lost: "no connection", asks: "a question", halted: "halted", running: "running" };

function state(change: Partial<StationState>): StationState {
  const still = { still: true, state: {}, holds: null };
  return {
    ...{ time: 0, cycle: 0, pace: 1, halted: "", standing: true, modules: [], tasks: [] },
    ...{ observations: {}, motions: {}, devices: { arm_1: still, arm_2: still, base_1: still, base_2: still } },
    ...change,
  } as StationState;
}

const ROBOTS = [1, 2].map((n) => ({
  id: `robot_${n}`,
  label: n === 1 ? "Anna" : "",
  devices: [{ id: `base_${n}` }, { id: `arm_${n}` }],
}));

test.each([
  [5, "0:05"],
  [75, "1:15"],
  [3675, "1:01:15"],
])("%d seconds are %s", (seconds, text) => {
  expect(clock(seconds)).toBe(text);
});

test("a robot moves when any of its devices does, and is named by its label", () => {
  const moving = state({});
  moving.devices["arm_1"] = { still: false, state: {}, holds: null };
  expect(movingRobots(moving, ROBOTS)).toBe("Anna");
  moving.devices["arm_2"] = { still: false, state: {}, holds: null };
  expect(movingRobots(moving, ROBOTS)).toBe("Anna, robot_2");
  expect(movingRobots(state({}), ROBOTS)).toBe("");
});

test("the window title shows the most important state", () => {
  const running = state({ tasks: [{ name: "kit-17", status: "running" }] });
  expect(windowTitle(running, false, 0, WORDS)).toBe("● kit-17 running – skiros");
  expect(windowTitle({ ...running, halted: "why" }, false, 0, WORDS)).toBe("■ halted – skiros");
  expect(windowTitle(running, false, 1, WORDS)).toBe("? a question – skiros");
  expect(windowTitle(running, true, 1, WORDS)).toBe("⚠ no connection – skiros");
  expect(windowTitle(null, false, 0, WORDS)).toBe("skiros");
});
