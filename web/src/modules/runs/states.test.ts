import { successRate } from "./states";

function run(...successes: boolean[]) {
  return { cut_off: false, done: successes.length, succeeded: successes.filter(Boolean).length };
}

test("a round that was stopped counts neither as a success nor as a failure", () => {
  expect(successRate({ ...run(true, false), cut_off: true })).toBe(100);
  expect(successRate({ ...run(true, false, false), cut_off: true })).toBe(50);
  expect(successRate({ ...run(false), cut_off: true })).toBeNull();
});

test("failed rounds count even if everything was stopped after them", () => {
  expect(successRate(run(true, false))).toBe(50);
  expect(successRate(run(true, false, true))).toBe(67);
});
