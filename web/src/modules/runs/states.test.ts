import type { Run } from "../queries";
import { successRate } from "./states";

const round = (success: boolean) => ({ success, code: success ? 1 : -1, text: "", start: 0, end: 1 });

function run(status: Run["status"], ...successes: boolean[]) {
  const succeeded = successes.filter(Boolean).length;
  return { status, rounds: successes.map(round), done: successes.length, succeeded };
}

test("a round that a stop cut off counts neither as a success nor as a failure", () => {
  expect(successRate(run("stopped", true, false))).toBe(100);
  expect(successRate(run("stopped", true, false, false))).toBe(50);
  expect(successRate(run("stopped", false))).toBeNull();
});

test("rounds that failed by themselves count", () => {
  expect(successRate(run("failed", true, false))).toBe(50);
  expect(successRate(run("running", true, false, true))).toBe(67);
  expect(successRate(run("stopped", true, true))).toBe(100);
});
