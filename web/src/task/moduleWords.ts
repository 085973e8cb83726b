import type { TFunction } from "i18next";

const KNOWN = ["started", "running", "paused", "resumed", "preempted", "terminated", "error", "event"] as const;

/** The state of a module in words; modules that have not started are still to come. */
export function moduleStatus(t: TFunction<"task">, status: string): string {
  if (status === "") return t("stepStates.planned");
  const known = KNOWN.find((one) => one === status);
  return known === undefined ? status : t(`moduleStates.${known}`);
}
