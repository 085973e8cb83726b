import type { Mood } from "../widgets/Status";
import type { Alarm } from "./useAlarms";

const ORDER: readonly Alarm["severity"][] = ["critical", "high", "medium", "low"];

export const MOODS: Record<Alarm["severity"], Mood> = {
  critical: "stopped",
  high: "bad",
  medium: "warning",
  low: "waiting",
};

/** Highest severity first, then newest first. */
export function bySeverity(alarms: readonly Alarm[]): Alarm[] {
  return alarms.toReversed().sort((one, other) => ORDER.indexOf(one.severity) - ORDER.indexOf(other.severity));
}

/** The highest severity; undefined without alarms. */
export function gravest(alarms: readonly Alarm[]): Alarm["severity"] | undefined {
  return ORDER.find((severity) => alarms.some((alarm) => alarm.severity === severity));
}
