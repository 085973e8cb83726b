import type { Schema } from "../api/client";
import { joined, readEntry, type Plan, readRun, type Run, type TraceEntry } from "./trace";
import { finish, schedule } from "./schedule";
import { fitting } from "./TimelineBar";
import { layOut } from "./timelineLayout";
import { windowOf } from "./useZoom";

function skill(name: string, agent: string, duration: number): [string, Schema<"SkillInfo">] {
  return [name, { name, agent, duration, parameters: [] } as unknown as Schema<"SkillInfo">];
}
const SKILLS = new Map([skill("drive", "Base", 20), skill("pick", "Arm", 6)]);
const DRIVE = { skill: "drive", arguments: { Base: "base_1", Location: "pallet_a" } };
const PICK = { skill: "pick", arguments: { Arm: "arm_1", Object: "starter_1" } };

function entry(time: number, what: string, more: Partial<TraceEntry> = {}): TraceEntry {
  return readEntry({ time, what, text: `${what} ${time}`, ...more });
}
function plan(time: number, calls = [DRIVE, PICK]): TraceEntry {
  const steps = calls.map((call) => `${call.skill}(…)`);
  return entry(time, "planned", { data: { steps, calls, after: [[], [0]], starts: [0, 20] } });
}
function step(time: number, what: string, number: number, call: typeof DRIVE | typeof PICK): TraceEntry {
  return entry(time, what, { step: number, ...call, agent: Object.values(call.arguments)[0] });
}
function planOf(run: Run): Plan {
  const plan = run.plans.at(-1);
  if (plan === undefined) throw new Error("there is no plan");
  return plan;
}
const GOOD = [entry(10, "begun"), plan(12), step(12, "started", 1, DRIVE), step(30, "ended", 1, DRIVE)];

test("a run contains the started steps with their ends", () => {
  const run = readRun([...GOOD, step(30, "started", 2, PICK)]);
  expect(run.steps.map(({ key, start, end, ended }) => [key, start, end, ended])).toEqual([
    ["1.1", 12, 30, "ended"],
    ["1.2", 30, null, null],
  ]);
});

test("run time continues after a restart of the server, and steps running then were cancelled", () => {
  const run = readRun([...GOOD, step(30, "started", 2, PICK), entry(2, "begun"), step(5, "started", 1, PICK)]);
  expect(run.steps.map(({ key, start, end, ended }) => [key, start, end, ended])).toEqual([
    ["1.1", 12, 30, "ended"],
    ["1.2", 30, 30, "cancelled"],
    ["2.1", 33, null, null],
  ]);
  expect(run.shift).toBe(28);
});

test("stored and live entries are merged without duplicates", () => {
  const lately = [...GOOD, entry(31, "finished")];
  expect(joined(GOOD, lately)).toEqual(lately);
  expect(joined([entry(1, "begun"), ...GOOD], lately)).toHaveLength(lately.length + 1);
  expect(joined(GOOD, [])).toEqual(GOOD);
});

test("a step that failed and is repeated makes two attempts at the same step of the plan", () => {
  const retried = [step(30, "started", 2, PICK), step(35, "failed", 2, PICK), step(36, "started", 3, PICK)];
  const run = readRun([...GOOD, ...retried]);
  const slots = schedule(planOf(run), run.steps, SKILLS, 38);
  expect(slots.map((slot) => [slot.done, slot.runs.map((one) => one.key)])).toEqual([
    [true, ["1.1"]],
    [false, ["1.2", "1.3"]],
  ]);
  const arm = layOut(run, SKILLS, 38, false).lanes.find(({ agent }) => agent === "arm_1");
  expect(arm?.bars.filter(({ kind }) => kind === "actual").map(({ row, state }) => [row, state])).toEqual([
    [1, "failed"],
    [2, "running"],
  ]);
});

test("the expected end follows from the remaining steps, not from the original plan", () => {
  const run = readRun([entry(10, "begun"), plan(12), step(12, "started", 1, DRIVE)]);
  expect(finish(schedule(planOf(run), run.steps, SKILLS, 20))).toBe(12 + 20 + 6);
  expect(finish(schedule(planOf(run), run.steps, SKILLS, 100))).toBe(100 + 6); // driving takes longer than planned
});

test("of an abandoned plan only the steps that never started are shown", () => {
  const run = readRun([...GOOD, entry(30, "replans"), plan(31, [DRIVE, DRIVE])]);
  const bars = layOut(run, SKILLS, 31, false).lanes.flatMap((lane) => lane.bars);
  expect(bars.filter(({ kind }) => kind === "old").map(({ title }) => title)).toEqual(["pick"]);
  expect(layOut(run, SKILLS, 31, false).replanned).toEqual([31]);
});

test("abandoned steps do not extend the timeline", () => {
  const other = { skill: "drive", arguments: { Base: "base_1", Location: "kit_1" } };
  const run = readRun([...GOOD, plan(31, [other]), entry(35, "finished")]);
  const late = [...GOOD.slice(0, 1), plan(12, [DRIVE, PICK, DRIVE, PICK, DRIVE]), ...GOOD.slice(2)];
  const longer = readRun([...late, plan(31, [other]), entry(35, "finished")]);
  expect(layOut(longer, SKILLS, 35, false).end).toBe(layOut(run, SKILLS, 35, false).end);
});

test("an ended timeline has no expected end", () => {
  expect(layOut(readRun([...GOOD, entry(31, "finished")]), SKILLS, 99, false).eta).toBeNull();
});

test.each([12, 120])("of %i steps, as many are shown at first as have room for their texts", (count) => {
  const calls = Array.from({ length: count }, () => DRIVE);
  const after = calls.map((_, index) => (index === 0 ? [] : [index - 1]));
  const starts = calls.map((_, index) => 20 * index);
  const steps = calls.map(({ skill: name }) => name);
  const run = readRun([entry(10, "begun"), entry(12, "planned", { data: { steps, calls, after, starts } })]);
  const layout = layOut(run, SKILLS, 12 + 10 * count, false);
  const { start, end } = windowOf(layout, { start: 10, end: 10 + layout.readable }, 12 + 10 * count);
  expect((20 / (end - start)) * 700).toBeGreaterThan(100); // px of a bar in a pane of 700 px
  expect(start).toBeLessThan(12 + 10 * count);
  expect(end).toBeGreaterThan(12 + 10 * count);
});

test("a bar shows as much as it has room for, and never a part of a word without a sign of that", () => {
  expect(fitting("✓", "takes starter_1", 200)).toBe("✓ takes starter_1");
  expect(fitting("✓", "takes starter_1 from pallet A", 120)).toMatch(/^✓ takes starter.*…$/);
  expect(fitting("✓", "takes starter_1", 40)).toBe("✓");
  expect(fitting("✓", "takes starter_1", 10)).toBe("");
});
