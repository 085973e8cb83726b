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

test("rounds are counted when all their steps worked, attempts one by one", () => {
  const run = readRun([...step(1), ...step(2), ...step(3, "failed"), ...step(4)]);
  expect(roundsOf(run, 2)).toEqual({ done: 1, tried: 4, worked: 3 });
});

test("the plan of a round begins where the round before it ended", () => {
  expect(withRound(readRun(step(1)), STEPS).plans[0]?.at).toBe(10);
  expect(withRound(readRun([...step(1), ...step(2)]), STEPS).plans[0]?.at).toBe(10);
  expect(withRound(readRun([...step(1), ...step(2), ...step(3)]), STEPS).plans[0]?.at).toBe(29);
});
