import type { TFunction } from "i18next";
import type { Schema } from "../api/client";

const OUTCOMES = [
  "succeeded",
  "partially succeeded",
  "goal already satisfied",
  "stopped",
  "aborted",
  "failed",
  "no plan",
  "expired",
] as const;

/** The activity or result of a job in words. */
export function jobState(t: TFunction<"task">, job: Schema<"Job">): string {
  if (job.outcome !== null) return outcomeText(t, job.outcome);
  const text = t(`jobStates.${job.state.text}`);
  if (job.choices.length > 0) return t("job.asks");
  return job.state.text === "Running" && job.detail === "planning" ? t("job.planning") : text;
}

/**
 * Explains why nothing was planned or executed in a job or a task.
 *
 * @param outcome - Its result; null while it runs.
 */
export function nothingDone(t: TFunction<"task">, outcome: string | null): string {
  if (outcome === null) return t("nothingDone.yet");
  if (outcome === "no plan") return t("nothingDone.noPlan");
  return HELD.includes(outcome) ? t("nothingDone.held") : t("nothingDone.ended");
}

const HELD: readonly string[] = ["goal already satisfied", "held already"];

function outcomeText(t: TFunction<"task">, outcome: string): string {
  const known = OUTCOMES.find((one) => one === outcome);
  return known === undefined ? outcome : t(`outcomes.${known}`);
}
