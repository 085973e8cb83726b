import { successRate } from "./states";

function run(...successes: boolean[]) {
  return { cut_off: false, done: successes.length, succeeded: successes.filter(Boolean).length };
}

test("a round that a stop cut off counts neither as a success nor as a failure", () => {
  expect(successRate({ ...run(true, false), cut_off: true })).toBe(100);
  expect(successRate({ ...run(true, false, false), cut_off: true })).toBe(50);
  expect(successRate({ ...run(false), cut_off: true })).toBeNull();
});

test("rounds that failed by themselves count, also where everything was stopped after them", () => {
  expect(successRate(run(true, false))).toBe(50);
  expect(successRate(run(true, false, true))).toBe(67);
});
