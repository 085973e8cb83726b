/** The history of a task, from the entries of its trace. */

import type { Schema } from "../api/client";
import { evened, type Shifts } from "./runTime";

export type PlannedStep = Schema<"PlannedStep">;

export interface TraceEntry {
  /** Id of its step or task. */
  id: string;
  /** Run time [s]; non-decreasing after {@link evened}. */
  time: number;
  /** Offset from the server's time [s]. */
  shift: number;
  what: string;
  text: string;
  step: number | null;
  skill: string;
  arguments: Record<string, string>;
  agent: string;
  data: Record<string, unknown>;
}

/** A condition of a step with its result. */
export interface ConditionRow {
  kind: string;
  condition: string;
  holds: boolean | null;
  why: string[];
}

export type StepEnd = "ended" | "failed" | "cancelled";

/** One started step; a repetition is another one. */
export interface Step {
  /** Its id in the server: the root of its modules' messages. */
  id: string;
  /** Key in the task, unique across restarts of the server. */
  key: string;
  number: number;
  skill: string;
  arguments: Record<string, string>;
  /** The given arguments; from its end on, all of them with the inferred ones. */
  inputs: Record<string, unknown>;
  agent: string;
  /** Run time [s]. */
  start: number;
  /** Run time [s]; null while it runs. */
  end: number | null;
  ended: StepEnd | null;
  /** The text of its start or its result. */
  text: string;
  conditions: ConditionRow[];
  /** Label of the implementation, known at its end; null if unknown. */
  implementation: string | null;
  /** Numbers of its changes of the world. */
  changes: number[];
  /** Offset of its times from the server's time [s]. */
  shift: number;
}

export interface Plan {
  /** Run time of the plan [s]. */
  at: number;
  steps: PlannedStep[];
}

export interface Run {
  begun: number;
  /** Run time of its end [s]; null while it runs. */
  end: number | null;
  /** Offset of its times from the server's current run time [s], which starts again with each run of the server. */
  shift: number;
  steps: Step[];
  /** All plans, the current one last. */
  plans: Plan[];
  entries: TraceEntry[];
}

export const NO_RUN: Run = { begun: 0, end: null, shift: 0, steps: [], plans: [], entries: [] };

const ENDS: readonly string[] = ["ended", "failed", "cancelled"];

/** Parses entries of the API: plain data, of which only the names are guaranteed. */
export function readEntry(raw: Record<string, unknown>): TraceEntry {
  return {
    time: typeof raw.time === "number" ? raw.time : 0,
    shift: 0,
    id: String(raw.id ?? ""),
    what: String(raw.what ?? ""),
    text: String(raw.text ?? ""),
    step: typeof raw.step === "number" ? raw.step : null,
    skill: String(raw.skill ?? ""),
    arguments: isRecord(raw.arguments) ? (raw.arguments as Record<string, string>) : {},
    agent: String(raw.agent ?? ""),
    data: isRecord(raw.data) ? raw.data : {},
  };
}

/**
 * Merges a job's stored entries with those of its running task.
 *
 * The former lag by up to a second and contain all attempts, the latter only the current one.
 */
export function joined(kept: readonly TraceEntry[], lately: readonly TraceEntry[]): TraceEntry[] {
  const first = lately[0];
  if (first === undefined) return [...kept];
  const from = kept.findLastIndex((entry) => isSame(entry, first));
  return from < 0 ? [...kept, ...lately] : [...kept.slice(0, from), ...lately];
}

/**
 * Builds the history from entries.
 *
 * @param shifts - The time offsets of a replay, if one is shown: then both use the same times.
 */
export function readRun(raw: readonly TraceEntry[], shifts: Shifts = []): Run {
  const entries = evened(raw, shifts);
  const shift = entries.at(-1)?.shift ?? 0;
  const run: Run = { begun: entries[0]?.time ?? 0, end: null, shift, steps: [], plans: [], entries };
  let attempt = 0;
  for (const entry of entries) {
    if (entry.what === "begun") {
      attempt += 1;
      breakOff(run.steps, entry.time);
      run.end = null;
    } else if (entry.what === "planned") run.plans.push({ at: entry.time, steps: plannedSteps(entry.data) });
    else if (entry.what === "started" && entry.step !== null) run.steps.push(started(entry, attempt, entry.step));
    else if (ENDS.includes(entry.what)) end(run.steps, entry);
    else if (entry.what === "finished") run.end = entry.time;
  }
  return run;
}

/**
 * Ends the steps that ran when the server stopped.
 *
 * @param until - The end of the replay [s]; otherwise the last entry counts.
 */
export function cutOff(run: Run, until = 0): Run {
  const last = run.entries.at(-1);
  if (last === undefined || run.end !== null) return run;
  const end = Math.max(last.time, until);
  const steps = run.steps.map((step) => ({ ...step }));
  breakOff(steps, end);
  return { ...run, steps, end };
}

function started(entry: TraceEntry, attempt: number, number: number): Step {
  return {
    id: entry.id,
    key: `${attempt}.${number}`,
    number,
    skill: entry.skill,
    arguments: entry.arguments,
    inputs: isRecord(entry.data.inputs) ? entry.data.inputs : entry.arguments,
    agent: entry.agent,
    start: entry.time,
    end: null,
    ended: null,
    text: entry.text,
    conditions: conditionRows(entry.data),
    implementation: null,
    changes: numbers(entry.data.changes),
    shift: entry.shift,
  };
}

function end(steps: Step[], entry: TraceEntry): void {
  const step = steps.findLast((one) => one.number === entry.step);
  if (step === undefined) return;
  step.end = entry.time;
  step.ended = entry.what as StepEnd;
  step.text = entry.text;
  if (isRecord(entry.data.inputs)) step.inputs = entry.data.inputs;
  if (typeof entry.data.implementation === "string") step.implementation = entry.data.implementation;
  step.conditions = [...step.conditions, ...conditionRows(entry.data)];
  step.changes = [...step.changes, ...numbers(entry.data.changes)];
}

/** Steps that ran when the server stopped have no end of their own. */
function breakOff(steps: Step[], time: number): void {
  for (const step of steps) {
    if (step.end !== null) continue;
    step.end = time;
    step.ended = "cancelled";
  }
}

function plannedSteps(data: Record<string, unknown>): PlannedStep[] {
  const texts = list(data.steps).map(String);
  const calls = list(data.calls);
  const after = list(data.after);
  const starts = list(data.starts);
  return texts.map((text, index) => {
    const call = calls[index];
    const start = starts[index];
    return {
      text,
      skill: isRecord(call) ? String(call.skill) : text.replace(/\(.*$/s, ""),
      arguments: isRecord(call) && isRecord(call.arguments) ? (call.arguments as Record<string, string>) : {},
      after: numbers(after[index]),
      start: typeof start === "number" ? start : null,
    };
  });
}

function conditionRows(data: Record<string, unknown>): ConditionRow[] {
  return list(data.conditions).flatMap((row) => {
    if (!isRecord(row)) return [];
    const holds = typeof row.holds === "boolean" ? row.holds : null;
    const why = list(row.why).map(String);
    return [{ kind: String(row.kind ?? ""), condition: String(row.condition ?? ""), holds, why }];
  });
}

function isSame(one: TraceEntry, other: TraceEntry): boolean {
  return one.time === other.time && one.what === other.what && one.text === other.text;
}

function list(value: unknown): unknown[] {
  return Array.isArray(value) ? value : [];
}

function numbers(value: unknown): number[] {
  return list(value).filter((one) => typeof one === "number");
}

function isRecord(value: unknown): value is Record<string, unknown> {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}
