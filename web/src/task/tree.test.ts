import type { Schema } from "../api/client";
import type { OutputRow } from "./output";
import type { Slot } from "./schedule";
import { bodyLines, messagesOf, skillTree, taskTree, wayOf } from "./tree";
import { readEntry, readRun, type Step } from "./trace";

const BODY = ["sequence", "  locate(part=Object)", "  move_arm(arm=Arm)", "move_arm(arm=Arm)"];
const SAID = { step: (state: string) => state, module: (status: string) => status || "to come" };
const ROOT = { id: "skill", title: "pick" };

function message(time: number, module: string, status: string, caller = "pick"): OutputRow {
  const rest = { at: 0, kind: "", code: 0, text: "", agent: "arm_1", implementation: null };
  return { id: `x-${time}`, time, module, status, caller, ...rest };
}

function graph(messages: OutputRow[]) {
  const lines = bodyLines({ body: BODY } as unknown as Schema<"Implementation">);
  return skillTree(ROOT, lines, messages, SAID);
}

test("what a skill does hangs below it as deep as it is written", () => {
  expect(graph([]).edges).toEqual([
    { from: "skill", to: "skill 0" },
    { from: "skill 0", to: "skill 1" },
    { from: "skill 0", to: "skill 2" },
    { from: "skill", to: "skill 3" },
  ]);
});

test("a module that a skill runs twice has a state for each time", () => {
  const { nodes } = graph([
    message(1, "move_arm", "started"),
    message(2, "move_arm", "terminated"),
    message(3, "move_arm", "started"),
    message(4, "move_arm", "error"),
  ]);
  expect(nodes.map(({ state }) => state?.text)).toEqual([undefined, undefined, "to come", "terminated", "error 0"]);
});

test("the messages of a step are those of its parts while it ran, in the time of this start of the server", () => {
  const run = readRun([
    readEntry({ time: 50, what: "begun" }),
    readEntry({ time: 10, what: "started", step: 1, skill: "pick", agent: "arm_1" }),
    readEntry({ time: 20, what: "ended", step: 1, skill: "pick", agent: "arm_1" }),
  ]);
  const rows = [
    message(9, "locate", "started"),
    message(12, "locate", "terminated"),
    message(25, "pick", "started", ""),
  ];
  expect(messagesOf(run.steps[0] as Step, rows, run.shift).map(({ time }) => time)).toEqual([12]);
});

const WAYS = [{ label: "by vision" }, { label: "by hand" }] as unknown as Schema<"Implementation">[];

function picked(implementation?: string) {
  const run = readRun([
    readEntry({ time: 10, what: "started", step: 1, skill: "pick", agent: "arm_1" }),
    ...(implementation === undefined
      ? []
      : [readEntry({ time: 20, what: "failed", step: 1, skill: "pick", agent: "arm_1", data: { implementation } })]),
  ]);
  return run.steps[0] as Step;
}

function own(time: number, implementation: string) {
  return { ...message(time, "pick", "running", ""), implementation };
}

test("a step shows the way in which it is done now, with what that way said alone", () => {
  const rows = [
    own(10, "by vision"),
    message(11, "locate", "error"),
    own(12, "by hand"),
    message(13, "grip", "started"),
  ];
  const [way, said] = wayOf(picked(), WAYS, rows);
  expect(way?.label).toBe("by hand");
  expect(said.map(({ time }) => time)).toEqual([12, 13]);
});

test("a step that is over shows the way that its trace names, also where its messages are gone", () => {
  expect(wayOf(picked("by hand"), WAYS, [])[0]?.label).toBe("by hand");
});

test("a step of which nobody says how it is done shows the way that is tried first", () => {
  const rows = [message(11, "locate", "started")];
  expect(wayOf(picked(), WAYS, rows)).toEqual([WAYS[0], rows]);
});

test("steps hang on those that they wait for, without what those wait for themselves", () => {
  const slots = [[], [0], [0, 1]].map((after, index): Slot => {
    const step = { text: "", skill: `s${index}`, arguments: {}, after, start: null };
    const span = { start: 0, end: 1 };
    return { index, step, agent: "arm_1", planned: span, expected: span, runs: [], done: false };
  });
  const task = { title: "kit", state: { mood: "running" as const, text: "runs" }, slots, others: [] };
  expect(taskTree(task, new Map(), SAID).edges).toEqual([
    { from: "task", to: "step 0" },
    { from: "step 0", to: "step 1" },
    { from: "step 1", to: "step 2" },
  ]);
});

test("steps of plans that were given up hang one below the other as they were done", () => {
  const told = [10, 20].flatMap((time, index) => [
    readEntry({ time, what: "started", step: index + 1, skill: "pick", agent: "arm_1" }),
    readEntry({ time: time + 5, what: "failed", step: index + 1, skill: "pick", agent: "arm_1" }),
  ]);
  const others = readRun(told).steps;
  const task = { title: "kit", state: { mood: "running" as const, text: "runs" }, slots: [], others };
  expect(taskTree(task, new Map(), SAID).edges).toEqual([
    { from: "task", to: "ran 0.1" },
    { from: "ran 0.1", to: "ran 0.2" },
  ]);
});
