import type { Mood } from "../../widgets/Status";
import type { Run } from "../queries";

export const MOODS: Record<Run["status"], Mood> = {
  running: "running",
  paused: "paused",
  stopping: "stopped",
  stopped: "stopped",
  succeeded: "good",
  failed: "bad",
};

export function isOver({ status }: Run): boolean {
  return status === "succeeded" || status === "failed" || status === "stopped";
}

/** Returns how many of the rounds that have ended worked [%]; null before the first. */
export function successRate({ done, succeeded }: Run): number | null {
  return done === 0 ? null : Math.round((100 * succeeded) / done);
}
