/** Steps of plans in words. */

import type { Schema } from "../api/client";

type Step = Pick<Schema<"PlannedStep">, "skill" | "arguments">;

/** A part of the description of a step: text, or the id of an element. */
export type StepPiece = { text: string } | { id: string };

type Parameter = Pick<Schema<"ModuleParameter">, "key" | "kind">;

/**
 * Describes a step by a sentence such as "{Robot} drives to {Location}".
 *
 * Without a sentence, by the skill's name and arguments, except devices of the robot.
 */
export function stepPieces(
  step: Step,
  sentences: Readonly<Record<string, string>>,
  parameters: readonly Parameter[] = [],
): StepPiece[] {
  return sentencePieces(step, sentences) ?? plainPieces(step, parameters);
}

/** Describes a step by its sentence; null if there is none, or an argument of it is missing. */
export function sentencePieces(step: Step, sentences: Readonly<Record<string, string>>): StepPiece[] | null {
  const sentence = sentences[step.skill];
  if (sentence === undefined || !isFilled(sentence, step)) return null;
  return sentence
    .split(/(\{\w+\})/)
    .filter((part) => part !== "")
    .map((part) => (part.startsWith("{") ? { id: step.arguments[part.slice(1, -1)] ?? "" } : { text: part }));
}

function isFilled(sentence: string, step: Step): boolean {
  return [...sentence.matchAll(/\{(\w+)\}/g)].every(([, name]) => (name ?? "") in step.arguments);
}

function plainPieces({ skill, arguments: given }: Step, parameters: readonly Parameter[]): StepPiece[] {
  const devices = new Set(parameters.filter(({ kind }) => kind === "hardware").map(({ key }) => key));
  const shown = Object.entries(given).filter(([name]) => !devices.has(name));
  return [{ text: skill }, ...shown.flatMap(([name, id]): StepPiece[] => [{ text: ` ${name}: ` }, { id }])];
}

/** Counts the completed steps of a plan; each step that ran counts for one step of the plan. */
export function doneOf(plan: readonly Step[], run: readonly RunStep[]): number {
  const left = run.filter(({ ended }) => ended === "ended");
  return plan.filter((step) => {
    const at = left.findLastIndex((one) => isDone(step, one));
    if (at >= 0) left.splice(at, 1);
    return at >= 0;
  }).length;
}

/** Parameters that the plan left open are filled in when a step starts. */
function isDone(planned: Step, ran: Step): boolean {
  const given = Object.entries(planned.arguments);
  return planned.skill === ran.skill && given.every(([name, value]) => ran.arguments[name] === value);
}

/** A step that ran, as a task reports it: ended, failed, cancelled, or null while it runs. */
type RunStep = Step & Pick<Schema<"TaskStep">, "ended">;

/** Minutes and seconds: "1:05". */
export function clock(seconds: number): string {
  const whole = Math.round(seconds);
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}
