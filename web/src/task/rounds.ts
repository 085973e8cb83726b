/** The rounds of a sequence that is run over and over: its steps come one after the other, again and again. */

import type { PlannedStep, Run } from "./trace";

export interface Rounds {
  /** Rounds in which all steps worked. */
  done: number;
  /** Attempts at steps, and how many of them worked. */
  tried: number;
  worked: number;
}

export function roundsOf(run: Run, steps: number): Rounds {
  const worked = run.steps.filter(({ ended }) => ended === "ended").length;
  const tried = run.steps.filter(({ ended }) => ended === "ended" || ended === "failed").length;
  return { done: steps === 0 ? 0 : Math.floor(worked / steps), tried, worked };
}

/** Adds the plan of the present round to a run without a plan. */
export function withRound(run: Run, steps: readonly PlannedStep[]): Run {
  if (run.plans.length > 0 || steps.length === 0) return run;
  const ends = run.steps.filter(({ ended }) => ended === "ended").map(({ end }) => end ?? run.begun);
  const before = steps.length * Math.floor((ends.length - 1) / steps.length); // the last round stays when it is done
  return { ...run, plans: [{ at: ends[before - 1] ?? run.begun, steps: [...steps] }] };
}
