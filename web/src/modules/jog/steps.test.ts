import { BASE_SIZES, DEGREE, JOINT_SIZES, rollPitchYaw, stepsTo, TOOL_SIZES, TURN_SIZES } from "./steps";

test("a motion is split into equal steps, none larger than the robot accepts, that end at the target", () => {
  const steps = stepsTo([0, 1, -1], [0.5, 1, -1.1]);
  expect(steps).toHaveLength(3);
  for (const step of steps) expect(Math.max(...step.map(Math.abs))).toBeLessThanOrEqual(0.2);
  const sums = [0, 1, 2].map((joint) => steps.reduce((sum, step) => sum + (step[joint] ?? 0), 0));
  expect(sums.map((sum) => Math.round(sum * 1e6) / 1e6)).toEqual([0.5, 0, -0.1]);
});

test("0.4 rad make two steps, and a joint at its target makes none", () => {
  expect(stepsTo([0], [0.4])).toHaveLength(2);
  expect(stepsTo([0.1], [0.1005])).toEqual([]);
});

test("no step size exceeds the server's limit", () => {
  expect(Math.max(...JOINT_SIZES) * DEGREE).toBeLessThanOrEqual(0.2);
  expect(Math.max(...TURN_SIZES) * DEGREE).toBeLessThanOrEqual(0.35);
  expect(Math.max(...TOOL_SIZES)).toBeLessThanOrEqual(100);
  expect(Math.max(...BASE_SIZES)).toBeLessThanOrEqual(200);
});

test("a quarter turn about each axis is computed as such", () => {
  const half = Math.SQRT1_2;
  expect(rollPitchYaw([half, 0, 0, half])[0]).toBeCloseTo(Math.PI / 2);
  expect(rollPitchYaw([0, half, 0, half])[1]).toBeCloseTo(Math.PI / 2);
  expect(rollPitchYaw([0, 0, half, half])[2]).toBeCloseTo(Math.PI / 2);
});
