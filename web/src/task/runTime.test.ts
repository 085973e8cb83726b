import { evened } from "./runTime";
import { cutOff, readEntry, readRun, type TraceEntry } from "./trace";

function entry(time: number, what = "started"): TraceEntry {
  return readEntry({ time, what, step: 1, skill: "drive", agent: "base_1" });
}
function times(entries: TraceEntry[], shifts: [number, number][] = []): number[] {
  return evened(entries, shifts).map(({ time }) => time);
}
const BEFORE = [entry(10, "begun"), entry(12), entry(30)];
const AFTER = [entry(2, "begun"), entry(5)];

test("without a replay, run time continues where it stopped", () => {
  expect(times([...BEFORE, ...AFTER])).toEqual([10, 12, 30, 30, 33]);
});

test("with a replay, all entries get its times, even if the second run of the server was longer than the first", () => {
  expect(times([...BEFORE, ...AFTER], [[31, 29]])).toEqual([10, 12, 30, 31, 34]);
  // Run time did not decrease: only the replay knows that there was a restart.
  expect(times([...BEFORE, entry(30.4, "begun"), entry(35)], [[31, 0.6]])).toEqual([10, 12, 30, 31, 35.6]);
});

test("entries that the replay lost in a crash come before later ones", () => {
  expect(times([...BEFORE, ...AFTER], [[29, 27]])).toEqual([10, 12, 29, 29, 32]);
});

test("a second restart may leave a smaller offset between replay and run time than the first, or none", () => {
  const third = [entry(100, "begun"), entry(101)];
  const shifts: [number, number][] = [
    [31, 29],
    [100, 0],
  ];
  expect(times([...BEFORE, ...AFTER, ...third], shifts)).toEqual([10, 12, 30, 31, 34, 100, 101]);
});

test("a job that was held and resumed without a restart keeps its times", () => {
  expect(times([...BEFORE, entry(60, "begun"), entry(61)], [])).toEqual([10, 12, 30, 60, 61]);
});

test("interrupted tasks and their steps end at their last known time", () => {
  const run = readRun(BEFORE);
  expect(cutOff(run).end).toBe(30);
  expect(cutOff(run, 33).steps.map(({ end, ended }) => [end, ended])).toEqual([
    [33, "cancelled"],
    [33, "cancelled"],
  ]);
  expect(run.steps.at(-1)?.end).toBeNull(); // the original entries are not modified
});
