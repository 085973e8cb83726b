import type { TFunction } from "i18next";
import type { Schema } from "../api/client";

const OUTCOMES = ["reached", "held already", "partly reached", "not reached", "no plan", "stopped"] as const;
const STATES = ["planning", "running", "paused", "waiting", "ended"] as const;

/** The activity or result of a task in words. */
export function taskState(t: TFunction<"task">, { status, report }: Schema<"TaskInfo">): string {
  const outcome = OUTCOMES.find((one) => one === report?.outcome);
  if (outcome !== undefined) return t(`taskOutcomes.${outcome}`);
  const known = STATES.find((one) => one === status);
  return known === undefined ? status : t(`taskStates.${known}`);
}
