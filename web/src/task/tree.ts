/** The tree of a task: its steps in order, and below each the nodes of its skill with their states. */

import type { Schema } from "../api/client";
import type { GraphEdge, GraphNode } from "../widgets/Graph";
import type { Mood } from "../widgets/Status";
import type { OutputRow } from "./output";
import type { Skills } from "../api/cell";
import type { Slot } from "./schedule";
import type { Step } from "./trace";
import { STEP_MOODS, stepState, stepTitle, type StepState } from "./words";

export interface StateTexts {
  /** The text of a state, for steps and for modules. */
  step: (state: StepState) => string;
  module: (status: string) => string;
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

/**
 * Returns the messages of a step's modules while it ran (or runs).
 *
 * @param shift - Offset of the current run times from the server's [s].
 */
export function messagesOf(step: Step, rows: readonly OutputRow[], shift: number): OutputRow[] {
  if (step.shift !== shift) return []; // it ran before a restart of the server, whose messages are not kept
  return rows.filter((row) => row.root === step.id);
}

/** Returns the implementation of a step, and the messages of its modules. */
export function wayOf(
  step: Step,
  ways: readonly Way[],
  messages: readonly OutputRow[],
): [Way | undefined, OutputRow[]] {
  const own = messages.filter(({ path }) => path === step.skill);
  const label = step.implementation ?? own.findLast(({ implementation }) => implementation !== null)?.implementation;
  const way = ways.find((one) => one.label === label) ?? ways[0]; // which is tried first
  const first = own.find(({ implementation }) => implementation !== null && implementation === label);
  return [way, first === undefined ? [...messages] : messages.slice(messages.indexOf(first))];
}

type Way = Schema<"Implementation">;

export interface Task {
  title: string;
  state: { mood: Mood; text: string };
  slots: readonly Slot[];
  /** Executed steps of abandoned plans. */
  others: readonly Step[];
}

/** Draws the task and its steps, each connected to its predecessors. */
export function taskTree(task: Task, skills: Skills, texts: StateTexts): { nodes: GraphNode[]; edges: GraphEdge[] } {
  const nodes: GraphNode[] = [{ id: "task", title: task.title, state: task.state }];
  const steps = [...task.others, ...task.slots.map(({ step }) => step)];
  const several = new Set(steps.map((step) => step.arguments["Robot"])).size > 1;
  const edges: GraphEdge[] = [];
  for (const step of task.others) {
    const state = stepState(step);
    const before = task.others.findLast(({ end }) => end !== null && end <= step.start);
    nodes.push({
      id: `ran ${step.key}`,
      title: stepTitle(step, skills, several),
      state: { mood: STEP_MOODS[state], text: texts.step(state) },
    });
    edges.push({ from: before === undefined ? "task" : `ran ${before.key}`, to: `ran ${step.key}` });
  }
  for (const slot of task.slots) {
    const state = stepState(slot.runs.at(-1));
    const tries = slot.runs.length > 1 ? ` (${slot.runs.length}×)` : "";
    const text = texts.step(state) + tries;
    nodes.push({
      id: `step ${slot.index}`,
      title: stepTitle(slot.step, skills, several),
      state: { mood: STEP_MOODS[state], text },
    });
    const before = reduced(slot, task.slots);
    if (before.length === 0) edges.push({ from: "task", to: `step ${slot.index}` });
    for (const other of before) edges.push({ from: `step ${other}`, to: `step ${slot.index}` });
  }
  return { nodes, edges };
}

/** The direct predecessors of a step. */
function reduced(slot: Slot, slots: readonly Slot[]): number[] {
  const implied = new Set(slot.step.after.flatMap((other) => slots[other]?.step.after ?? []));
  return slot.step.after.filter((other) => !implied.has(other));
}

/**
 * Draws the nodes of a skill below its step, with their last messages.
 *
 * @param skill - The skill: its name precedes the paths of its nodes in messages.
 */
export function skillTree(
  root: GraphNode,
  skill: string,
  way: Pick<Way, "nodes" | "edges"> | undefined,
  messages: readonly OutputRow[],
  texts: StateTexts,
): { nodes: GraphNode[]; edges: GraphEdge[] } {
  const own = (way?.nodes ?? []).map(({ path, title, module }) => {
    const state = module === "" ? {} : { state: stateOf(`${skill}/${path}`, messages, texts) };
    return { id: path, title, ...state };
  });
  const edges = (way?.edges ?? []).map(({ source, target, label }) => {
    const ends = { from: source || root.id, to: target || root.id };
    return label === "" ? ends : { ...ends, label };
  });
  return { nodes: [root, ...own], edges };
}

/** The last message of a node's last run: for a node in a loop, that of the current round. */
function stateOf(path: string, messages: readonly OutputRow[], texts: StateTexts): GraphNode["state"] & object {
  const last = messages.findLast((row) => row.path === path && row.status !== "event");
  if (last === undefined) return { mood: "waiting", text: texts.module("") };
  const text = last.status === "error" ? `${texts.module(last.status)} ${last.code}` : texts.module(last.status);
  return { mood: moduleMood(last.status), text };
}
