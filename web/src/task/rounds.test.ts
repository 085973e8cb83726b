import { readEntry, readRun, type TraceEntry } from "./trace";
import { roundsOf, withRound } from "./rounds";

const STEPS = ["drive(Location=pallet_a)", "drive(Location=kit_1)"].map((text) => {
  return { text, skill: "drive", arguments: {}, after: [], start: null };
});

function step(number: number, end = "ended"): TraceEntry[] {
  const more = { step: number, skill: "drive", agent: "base_1" };
  return [
    readEntry({ time: 10 * number, what: "started", ...more }),
    readEntry({ time: 10 * number + 9, what: end, ...more }),
  ];
}

test("a round counts if all its steps succeeded; attempts count individually", () => {
  const run = readRun([...step(1), ...step(2), ...step(3, "failed"), ...step(4)]);
  expect(roundsOf(run, 2)).toEqual({ done: 1, tried: 4, worked: 3 });
});

test("the plan of a round starts at the end of the previous round", () => {
  expect(withRound(readRun(step(1)), STEPS).plans[0]?.at).toBe(10);
  expect(withRound(readRun([...step(1), ...step(2)]), STEPS).plans[0]?.at).toBe(10);
  expect(withRound(readRun([...step(1), ...step(2), ...step(3)]), STEPS).plans[0]?.at).toBe(29);
});
