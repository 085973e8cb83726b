/** The tree of a task: its steps in their order, and below each the parts of its skill, with what they do. */

import type { Schema } from "../api/client";
import type { GraphEdge, GraphNode } from "../widgets/Graph";
import type { Mood } from "../widgets/Status";
import type { OutputRow } from "./output";
import type { Skills, Slot } from "./schedule";
import type { Step } from "./trace";
import { STEP_MOODS, stepState, stepTitle, type StepState } from "./words";

export interface Said {
  /** Says a state: for steps and for modules. */
  step: (state: StepState) => string;
  module: (status: string) => string;
}

export interface BodyLine {
  text: string;
  /** How far it is indented: 0 for the first ones. */
  depth: number;
  /** Name of the module that it runs; empty for what only puts others in order. */
  module: string;
}

const MODULE_MOODS: Record<string, Mood> = {
  started: "running",
  running: "running",
  paused: "stopped",
  resumed: "running",
  terminated: "good",
  preempted: "stopped",
  error: "bad",
};

export function moduleMood(status: string): Mood {
  return MODULE_MOODS[status] ?? "waiting";
}

/** Reads what a skill does: a line a node, indented by two blanks a level. */
export function bodyLines(implementation: Schema<"Implementation"> | undefined): BodyLine[] {
  return (implementation?.body ?? []).map((line) => {
    const text = line.trimStart();
    return { text, depth: (line.length - text.length) / 2, module: /^([\w.-]+)\(/.exec(text)?.[1] ?? "" };
  });
}

/**
 * Returns the messages of the parts of a step while it ran (or runs).
 *
 * @param shift - How much later the times of the present are than those that the server says now [s].
 */
export function messagesOf(step: Step, rows: readonly OutputRow[], shift: number): OutputRow[] {
  if (step.shift !== shift) return []; // it ran before the server was started anew, and messages are not kept so long
  const [start, end] = [step.start - shift, (step.end ?? Number.POSITIVE_INFINITY) - shift];
  return rows.filter((row) => row.time >= start - EDGE && row.time <= end + EDGE && isOf(step, row));
}

const EDGE = 0.004; // s: a cycle is 5 ms, and what ends a step is said in the one before

function isOf(step: Step, row: OutputRow): boolean {
  return row.agent === step.agent && (row.module === step.skill || row.caller !== "");
}

/** Returns in which way a step is (or was) done, and what the parts of that way said. */
export function wayOf(
  step: Step,
  ways: readonly Way[],
  messages: readonly OutputRow[],
): [Way | undefined, OutputRow[]] {
  const own = messages.filter(({ module, caller }) => module === step.skill && caller === "");
  const label = step.implementation ?? own.findLast(({ implementation }) => implementation !== null)?.implementation;
  const way = ways.find((one) => one.label === label) ?? ways[0]; // which is tried first
  const begun = own.find(({ implementation }) => implementation !== null && implementation === label);
  return [way, begun === undefined ? [...messages] : messages.slice(messages.indexOf(begun))];
}

type Way = Schema<"Implementation">;

export interface Task {
  title: string;
  state: { mood: Mood; text: string };
  slots: readonly Slot[];
  /** Steps that ran and belong to no present plan: of plans that were given up. */
  others: readonly Step[];
}

/** Draws the task and its steps; each after those that it waits for. */
export function taskTree(task: Task, skills: Skills, said: Said): { nodes: GraphNode[]; edges: GraphEdge[] } {
  const nodes: GraphNode[] = [{ id: "task", title: task.title, state: task.state }];
  const edges: GraphEdge[] = [];
  for (const step of task.others) {
    const state = stepState(step);
    const before = task.others.findLast(({ end }) => end !== null && end <= step.start);
    nodes.push({
      id: `ran ${step.key}`,
      title: stepTitle(step, skills),
      state: { mood: STEP_MOODS[state], text: said.step(state) },
    });
    edges.push({ from: before === undefined ? "task" : `ran ${before.key}`, to: `ran ${step.key}` });
  }
  for (const slot of task.slots) {
    const state = stepState(slot.runs.at(-1));
    const tries = slot.runs.length > 1 ? ` (${slot.runs.length}×)` : "";
    const text = said.step(state) + tries;
    nodes.push({
      id: `step ${slot.index}`,
      title: stepTitle(slot.step, skills),
      state: { mood: STEP_MOODS[state], text },
    });
    const before = reduced(slot, task.slots);
    if (before.length === 0) edges.push({ from: "task", to: `step ${slot.index}` });
    for (const other of before) edges.push({ from: `step ${other}`, to: `step ${slot.index}` });
  }
  return { nodes, edges };
}

/** What a step waits for, without what those wait for themselves. */
function reduced(slot: Slot, slots: readonly Slot[]): number[] {
  const implied = new Set(slot.step.after.flatMap((other) => slots[other]?.step.after ?? []));
  return slot.step.after.filter((other) => !implied.has(other));
}

/** Draws what a skill does below its step, with the last thing that each part said. */
export function skillTree(
  root: GraphNode,
  lines: readonly BodyLine[],
  messages: readonly OutputRow[],
  said: Said,
): { nodes: GraphNode[]; edges: GraphEdge[] } {
  const nodes: GraphNode[] = [root];
  const edges: GraphEdge[] = [];
  const path = [root.id];
  const turns = new Map<string, number>();
  lines.forEach((line, index) => {
    const id = `${root.id} ${index}`;
    path.length = line.depth + 1;
    edges.push({ from: path.at(-1) ?? root.id, to: id });
    path.push(id);
    const turn = turns.get(line.module) ?? 0;
    turns.set(line.module, turn + 1);
    nodes.push({ id, title: line.text, ...stateOf(line, turn, messages, said) });
  });
  return { nodes, edges };
}

/** A module that a skill runs several times: the n-th place of it did the n-th of its runs. */
function stateOf(line: BodyLine, turn: number, messages: readonly OutputRow[], said: Said): Pick<GraphNode, "state"> {
  if (line.module === "") return {};
  const own = runsOf(messages.filter((row) => row.module === line.module && row.caller !== ""));
  const last = own[turn]?.at(-1);
  if (last === undefined) return { state: { mood: "waiting", text: said.module("") } };
  const text = last.status === "error" ? `${said.module(last.status)} ${last.code}` : said.module(last.status);
  return { state: { mood: moduleMood(last.status), text } };
}

function runsOf(rows: readonly OutputRow[]): OutputRow[][] {
  const runs: OutputRow[][] = [];
  for (const row of rows) {
    if (row.status === "started" || runs.length === 0) runs.push([]);
    runs.at(-1)?.push(row);
  }
  return runs;
}
