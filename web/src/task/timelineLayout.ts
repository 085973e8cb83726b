/** The positions of bars in a timeline: a lane for each subsystem, with rows for plan, attempts and old plans. */

import { byName } from "../widgets/names";
import type { Mood } from "../widgets/Status";
import type { Skills } from "../api/cell";
import { finish, schedule, type Slot, type Span } from "./schedule";
import type { Run, Step } from "./trace";
import { STEP_MOODS, stepState, stepTitle, type StepState } from "./words";

export interface Bar extends Span {
  key: string;
  kind: "plan" | "actual" | "expected" | "old";
  title: string;
  state: StepState;
  mood: Mood;
  /** Key of the executed step; null if it has not started. */
  step: string | null;
  /** Row in the lane, from 0. */
  row: number;
  /** Number of the attempt at the same step, from 1. */
  attempt: number;
}

export interface Lane {
  agent: string;
  bars: Bar[];
  rows: number;
}

export interface TimelineLayout extends Span {
  lanes: Lane[];
  /** Expected end of the plan [s, run time]; null if ended or unknown. */
  eta: number | null;
  /** Times of replanning [s, run time]. */
  replanned: number[];
  slots: Slot[];
  /** Length of a part of it whose bars have room for their texts [s]. */
  readable: number;
}

const BARS = 5; // side by side
const SHORTEST = 10; // s, minimum length of a timeline

export function layOut(run: Run, skills: Skills, now: number, paused: boolean): TimelineLayout {
  const present = run.plans.at(-1);
  const slots = present === undefined ? [] : schedule(present, run.steps, skills, now);
  const eta = run.end === null ? finish(slots) : null;
  const bars = [...planBars(slots, skills), ...oldBars(run, skills), ...actualBars(run, skills, now, paused)];
  if (run.end === null) bars.push(...expectedBars(slots, skills));
  const shown = bars.filter(({ bar }) => bar.kind !== "old"); // abandoned steps may have been planned for much later
  const end = Math.max(run.end ?? now, ...shown.map(({ bar }) => bar.end), run.begun + SHORTEST);
  return {
    start: run.begun,
    end,
    lanes: lanes(bars),
    eta,
    replanned: run.plans.slice(1).map((plan) => plan.at),
    slots,
    readable: Math.max(SHORTEST, BARS * usual(shown.map(({ bar }) => bar.end - bar.start))),
  };
}

/** The median. */
function usual(lengths: number[]): number {
  return lengths.sort((one, other) => one - other)[Math.floor(lengths.length / 2)] ?? 0;
}

interface Placed {
  agent: string;
  bar: Bar;
}

function planBars(slots: readonly Slot[], skills: Skills): Placed[] {
  return slots.map((slot) => ({
    agent: slot.agent,
    bar: {
      ...slot.planned,
      ...about(slot, skills),
      key: `plan ${slot.index}`,
      kind: "plan",
      step: slot.runs.at(-1)?.key ?? null,
      row: 0,
      attempt: 1,
    },
  }));
}

/** Steps to come, at their expected times. */
function expectedBars(slots: readonly Slot[], skills: Skills): Placed[] {
  return slots
    .filter((slot) => !slot.done && slot.runs.at(-1)?.end !== null)
    .map((slot) => ({
      agent: slot.agent,
      bar: {
        ...slot.expected,
        ...about(slot, skills),
        key: `expected ${slot.index}`,
        kind: "expected",
        state: "planned",
        mood: "waiting",
        step: null,
        row: 1,
        attempt: slot.runs.length + 1,
      },
    }));
}

function about(slot: Slot, skills: Skills): Pick<Bar, "title" | "state" | "mood"> {
  const state = stepState(slot.runs.at(-1));
  return { title: stepTitle(slot.step, skills), state, mood: STEP_MOODS[state] };
}

/** The steps of abandoned plans that never started. */
function oldBars(run: Run, skills: Skills): Placed[] {
  return run.plans.slice(0, -1).flatMap((plan, index) => {
    const until = run.plans[index + 1]?.at ?? plan.at;
    const ran = run.steps.filter((step) => step.start < until);
    return schedule(plan, ran, skills, until)
      .filter((slot) => slot.runs.length === 0)
      .map((slot) => ({
        agent: slot.agent,
        bar: {
          ...slot.planned,
          ...about(slot, skills),
          key: `old ${index} ${slot.index}`,
          kind: "old" as const,
          step: null,
          row: 0,
          attempt: 1,
        },
      }));
  });
}

function actualBars(run: Run, skills: Skills, now: number, paused: boolean): Placed[] {
  const tried = new Map<string, number>();
  return run.steps.map((step) => {
    const same = `${step.agent} ${step.skill} ${JSON.stringify(step.arguments)}`;
    const attempt = (tried.get(same) ?? 0) + 1;
    tried.set(same, step.ended === "ended" ? 0 : attempt); // repeating a successful step later is not a retry
    const state = step.end === null && paused ? "paused" : stepState(step);
    return { agent: step.agent, bar: actual(step, state, attempt, stepTitle(step, skills), now) };
  });
}

function actual(step: Step, state: StepState, attempt: number, title: string, now: number): Bar {
  const end = Math.max(step.start, step.end ?? now);
  const mood = STEP_MOODS[state];
  return { key: step.key, kind: "actual", title, state, mood, step: step.key, start: step.start, end, row: 1, attempt };
}

/** Arranges bars in lanes and rows: the plan on top, each attempt below the previous one, old plans at the bottom. */
function lanes(placed: readonly Placed[]): Lane[] {
  const agents = [...new Set(placed.map(({ agent }) => agent))].sort(byName);
  return agents.map((agent) => {
    const bars = placed.filter((one) => one.agent === agent).map(({ bar }) => bar);
    const attempts = Math.max(1, ...bars.filter(isWork).map((bar) => bar.attempt));
    const old = bars.some((bar) => bar.kind === "old");
    return {
      agent,
      bars: bars.map((bar) => ({ ...bar, row: row(bar, attempts) })),
      rows: 1 + attempts + (old ? 1 : 0),
    };
  });
}

function isWork(bar: Bar): boolean {
  return bar.kind === "actual" || bar.kind === "expected";
}

function row(bar: Bar, attempts: number): number {
  if (bar.kind === "plan") return 0;
  return bar.kind === "old" ? attempts + 1 : bar.attempt;
}
