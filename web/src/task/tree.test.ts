import type { Schema } from "../api/client";
import type { OutputRow } from "./output";
import type { Slot } from "./schedule";
import { messagesOf, skillTree, taskTree, wayOf } from "./tree";
import { readEntry, readRun, type Step } from "./trace";

const SAID = { step: (state: string) => state, module: (status: string) => status || "to come" };
const ROOT = { id: "skill", title: "pick" };
const NODES: [path: string, module: string][] = [
  ["body", ""],
  ["body/0", ""],
  ["body/0/0", "move_arm"],
  ["body/1", "move_arm"],
];
const WAY = {
  nodes: NODES.map(([path, module]) => ({ path, module, kind: "", title: path })),
  edges: [
    { source: "", target: "body", label: "" },
    { source: "body", target: "body/0", label: "" },
    { source: "body/0", target: "body/0/0", label: "again" },
    { source: "body/0/0", target: "body/0", label: "" },
    { source: "body", target: "body/1", label: "" },
  ],
};
const STEP = "kit#1";

function message(time: number, path: string, status: string, run = "r1", root = STEP): OutputRow {
  const rest = { at: 0, kind: "", code: 0, text: "", agent: "arm_1", caller: "", implementation: null };
  return { id: `x-${time}`, time, module: "move_arm", path, status, run, root, ...rest };
}

function states(messages: OutputRow[]) {
  const { nodes } = skillTree(ROOT, "pick", WAY, messages, SAID);
  return Object.fromEntries(nodes.map(({ id, state }) => [id, state?.text]));
}

test("a skill is drawn with the server's edges, including loops and labels", () => {
  expect(skillTree(ROOT, "pick", WAY, [], SAID).edges).toEqual([
    { from: "skill", to: "body" },
    { from: "body", to: "body/0" },
    { from: "body/0", to: "body/0/0", label: "again" },
    { from: "body/0/0", to: "body/0" },
    { from: "body", to: "body/1" },
  ]);
});

test("two branches of one module and the rounds of a loop are distinguished by their paths", () => {
  const loop = [
    message(1, "pick/body/0/0", "started", "r1"),
    message(2, "pick/body/1", "started", "r2"),
    message(3, "pick/body/0/0", "terminated", "r1"),
    message(4, "pick/body/0/0", "started", "r3"),
    message(5, "pick/body/1", "error", "r2"),
  ];
  expect(states(loop)).toEqual({
    skill: undefined,
    body: undefined,
    "body/0": undefined,
    "body/0/0": "started",
    "body/1": "error 0",
  });
});

test("a node that has not run is still to come, even if its module ran elsewhere", () => {
  expect(states([message(1, "pick/body/1", "terminated")])["body/0/0"]).toBe("to come");
});

test("the messages of a step are those with its id as root, since the start of this server", () => {
  const started = { time: 10, what: "started", step: 1, skill: "pick", agent: "arm_1", id: STEP };
  const run = readRun([readEntry({ time: 50, what: "begun" }), readEntry(started)]);
  const rows = [message(12, "pick/body/1", "started"), message(13, "pick/body/1", "started", "r9", "kit#2")];
  const of = (shift: number) => messagesOf(run.steps[0] as Step, rows, shift).map(({ time }) => time);
  expect(of(run.shift)).toEqual([12]);
  expect(of(run.shift - 1)).toEqual([]);
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
  return { ...message(time, "pick", "running"), implementation };
}

test("a running step shows its current implementation, with the messages of that one only", () => {
  const rows = [
    own(10, "by vision"),
    message(11, "pick/body/0", "error"),
    own(12, "by hand"),
    message(13, "pick/body/1", "started"),
  ];
  const [way, messages] = wayOf(picked(), WAYS, rows);
  expect(way?.label).toBe("by hand");
  expect(messages.map(({ time }) => time)).toEqual([12, 13]);
});

test("an ended step shows the implementation named in its trace, even if its messages are gone", () => {
  expect(wayOf(picked("by hand"), WAYS, [])[0]?.label).toBe("by hand");
});

test("a step with an unknown implementation shows the one that is tried first", () => {
  const rows = [message(11, "pick/body/0", "started")];
  expect(wayOf(picked(), WAYS, rows)).toEqual([WAYS[0], rows]);
});

test("steps are connected to their direct predecessors only", () => {
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

test("steps of abandoned plans are chained in the order of execution", () => {
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
