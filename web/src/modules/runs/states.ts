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

/** Whether the last round was cut off, by whoever stopped the run or everything: it says nothing of the module. */
export function isCutOff({ status, rounds }: Pick<Run, "status" | "rounds">): boolean {
  return status === "stopped" && rounds.at(-1)?.success === false;
}

/** Returns how many of the rounds that have come to an end worked [%]; null before the first. */
export function successRate(run: Pick<Run, "status" | "rounds" | "done" | "succeeded">): number | null {
  const ended = run.done - (isCutOff(run) ? 1 : 0);
  return ended === 0 ? null : Math.round((100 * run.succeeded) / ended);
}
