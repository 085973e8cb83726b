import type { TFunction } from "i18next";

const KNOWN = ["started", "running", "paused", "resumed", "preempted", "terminated", "error", "event"] as const;

/** Says the state of a module; one that has not begun is to come. */
export function moduleStatus(t: TFunction<"task">, status: string): string {
  if (status === "") return t("stepStates.planned");
  const known = KNOWN.find((one) => one === status);
  return known === undefined ? status : t(`moduleStates.${known}`);
}
