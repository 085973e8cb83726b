import type { Mood } from "../widgets/Status";
import type { Alarm } from "./useAlarms";

const ORDER: readonly Alarm["severity"][] = ["critical", "high", "medium", "low"];

export const MOODS: Record<Alarm["severity"], Mood> = {
  critical: "stopped",
  high: "bad",
  medium: "warning",
  low: "waiting",
};

/** The gravest first, and of equals the youngest. */
export function bySeverity(alarms: readonly Alarm[]): Alarm[] {
  return alarms.toReversed().sort((one, other) => ORDER.indexOf(one.severity) - ORDER.indexOf(other.severity));
}

/** The gravest severity; undefined where there is no alarm. */
export function gravest(alarms: readonly Alarm[]): Alarm["severity"] | undefined {
  return ORDER.find((severity) => alarms.some((alarm) => alarm.severity === severity));
}
