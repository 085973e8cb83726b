/** Assigns executed steps to the steps of a plan, and predicts the times of the rest. */

import type { Skills } from "../api/cell";
import type { Plan, PlannedStep, Step } from "./trace";

export interface Span {
  /** Run time [s]. */
  start: number;
  end: number;
}

/** A step of a plan with its state. */
export interface Slot {
  index: number;
  step: PlannedStep;
  /** Id of the executing subsystem; empty if unknown. */
  agent: string;
  planned: Span;
  /** Its attempts, in order. */
  runs: Step[];
  done: boolean;
  /** Actual or predicted times. */
  expected: Span;
}

const USUAL = 10; // s, of a skill without a known duration

export function agentOf(step: PlannedStep, skills: Skills): string {
  const parameter = skills.get(step.skill)?.agent;
  return (parameter !== undefined && step.arguments[parameter]) || "";
}

/** Returns the steps of a plan, updated with the steps executed since; `now` in run time [s]. */
export function schedule(plan: Plan, ran: readonly Step[], skills: Skills, now: number): Slot[] {
  const slots = planned(plan, skills);
  for (const step of ran) if (step.start >= plan.at) take(slots, step);
  for (const slot of slots) slot.expected = expected(slot, slots, skills, now);
  return slots;
}

/** Predicted end of the last step of a plan [s, run time]; null without steps. */
export function finish(slots: readonly Slot[]): number | null {
  return slots.length === 0 ? null : Math.max(...slots.map((slot) => slot.expected.end));
}

function planned(plan: Plan, skills: Skills): Slot[] {
  const slots: Slot[] = [];
  plan.steps.forEach((step, index) => {
    const before = step.after.map((other) => slots[other]?.planned.end ?? plan.at);
    const start = step.start === null ? Math.max(plan.at, ...before) : plan.at + step.start;
    const span = { start, end: start + duration(step, skills) };
    slots.push({ index, step, agent: agentOf(step, skills), planned: span, runs: [], done: false, expected: span });
  });
  return slots;
}

/** Assigns an executed step to the first matching step of the plan. */
function take(slots: readonly Slot[], ran: Step): void {
  const slot = slots.find((one) => !one.done && isAttempt(one.step, ran) && !one.runs.some((run) => run.end === null));
  if (slot === undefined) return;
  slot.runs.push(ran);
  slot.done = ran.ended === "ended";
}

/** Parameters that the plan left open are filled in when a step starts. */
function isAttempt(step: PlannedStep, ran: Step): boolean {
  return (
    step.skill === ran.skill && Object.entries(step.arguments).every(([key, value]) => ran.arguments[key] === value)
  );
}

function expected(slot: Slot, slots: readonly Slot[], skills: Skills, now: number): Span {
  const last = slot.runs.at(-1);
  const long = duration(slot.step, skills);
  if (last !== undefined && slot.done) return { start: last.start, end: last.end ?? now };
  if (last !== undefined && last.end === null) return { start: last.start, end: Math.max(now, last.start + long) };
  const before = slot.step.after.map((other) => slots[other]?.expected.end ?? now);
  const start = Math.max(now, ...before);
  return { start, end: start + long };
}

function duration(step: PlannedStep, skills: Skills): number {
  return skills.get(step.skill)?.duration ?? USUAL;
}
