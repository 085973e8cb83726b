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

/**
 * Returns the share of completed rounds that succeeded [%]; null before the first.
 *
 * Stopped rounds do not count.
 */
export function successRate(run: Pick<Run, "cut_off" | "done" | "succeeded">): number | null {
  const ended = run.done - (run.cut_off ? 1 : 0);
  return ended === 0 ? null : Math.round((100 * run.succeeded) / ended);
}
