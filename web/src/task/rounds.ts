/** The rounds of a repeated sequence, whose steps run one after another. */

import type { PlannedStep, Run } from "./trace";

export interface Rounds {
  /** Rounds in which all steps succeeded. */
  done: number;
  /** Number of attempts, and of successful ones. */
  tried: number;
  worked: number;
}

export function roundsOf(run: Run, steps: number): Rounds {
  const worked = run.steps.filter(({ ended }) => ended === "ended").length;
  const tried = run.steps.filter(({ ended }) => ended === "ended" || ended === "failed").length;
  return { done: steps === 0 ? 0 : Math.floor(worked / steps), tried, worked };
}

/** Adds the plan of the current round to a run without a plan. */
export function withRound(run: Run, steps: readonly PlannedStep[]): Run {
  if (run.plans.length > 0 || steps.length === 0) return run;
  const ends = run.steps.filter(({ ended }) => ended === "ended").map(({ end }) => end ?? run.begun);
  const before = steps.length * Math.floor((ends.length - 1) / steps.length); // after its end, the last round stays
  return { ...run, plans: [{ at: ends[before - 1] ?? run.begun, steps: [...steps] }] };
}
