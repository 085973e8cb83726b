/** Short texts for steps and states. */

import type { Schema } from "../api/client";
import { sentencePieces } from "../goal/steps";
import i18n from "../i18n";
import { nameNow } from "../widgets/names";
import type { Mood } from "../widgets/Status";
import type { Step } from "./trace";
import type { Skills } from "../api/cell";

export type StepState = "planned" | "running" | "paused" | "ended" | "failed" | "cancelled";

export const STEP_MOODS: Record<StepState, Mood> = {
  planned: "waiting",
  running: "running",
  paused: "paused",
  ended: "good",
  failed: "bad",
  cancelled: "stopped",
};

export function stepState(step: Step | undefined): StepState {
  if (step === undefined) return "planned";
  return step.ended ?? "running";
}

/**
 * A step as a sentence, "takes starter_1 from pallet A"; otherwise its skill with its objects, without devices.
 *
 * @param whole - Whether the sentence begins with the robot.
 */
export function stepTitle(step: Pick<Step, "skill" | "arguments">, skills: Skills, whole = false): string {
  const robot = step.arguments["Robot"];
  const pieces = sentencePieces(
    { ...step, arguments: { Robot: "", ...step.arguments } },
    i18n.t("goal:steps", { returnObjects: true }),
  );
  if (pieces !== null) {
    const said = pieces.filter((piece) => "text" in piece || (piece.id !== "" && (whole || piece.id !== robot)));
    return said
      .map((piece) => ("id" in piece ? nameNow(piece.id) : piece.text))
      .join("")
      .trim();
  }
  const parameters = skills.get(step.skill)?.parameters;
  const about =
    parameters === undefined
      ? Object.values(step.arguments)
      : parameters
          .filter(({ kind }) => kind !== "hardware" && kind !== "planning")
          .map(({ key }) => step.arguments[key])
          .filter((value) => value !== undefined);
  return [step.skill, ...about.map(nameNow)].join(" ");
}

const JOB_MOODS: Record<Schema<"StateName">, Mood> = {
  NotAllowedToStart: "paused",
  AllowedToStart: "waiting",
  Running: "running",
  Interrupted: "paused",
  Ended: "good",
  Aborted: "stopped",
};

export function jobMood(job: Schema<"Job">): Mood {
  if (job.choices.length > 0) return "asking";
  if (job.state.text === "Ended" && !isGood(job.outcome))
    return job.outcome === "partially succeeded" ? "warning" : "bad";
  return JOB_MOODS[job.state.text];
}

function isGood(outcome: string | null): boolean {
  return outcome === "succeeded" || outcome === "goal already satisfied";
}

const TASK_MOODS: Record<string, Mood> = {
  planning: "running",
  running: "running",
  paused: "paused",
  waiting: "asking",
};

export function taskMood({ status, report }: Schema<"TaskInfo">): Mood {
  if (status !== "ended") return TASK_MOODS[status] ?? "waiting";
  if (report?.outcome === "stopped") return "stopped";
  return report?.reached === true ? "good" : "bad";
}

/** Seconds as "1 min 05 s". */
export function span(seconds: number): string {
  const whole = Math.max(0, Math.round(seconds));
  if (whole < 60) return `${whole} s`;
  const [minutes, rest] = [Math.floor(whole / 60), whole % 60];
  if (minutes < 60) return `${minutes} min ${String(rest).padStart(2, "0")} s`;
  return `${Math.floor(minutes / 60)} h ${String(minutes % 60).padStart(2, "0")} min`;
}
