/** Steps of plans in words. */

import type { Schema } from "../api/client";

type Step = Pick<Schema<"PlannedStep">, "skill" | "arguments">;

/** A piece of what is said about a step: words, or the id of an element. */
export type StepPiece = { text: string } | { id: string };

/** Parameters that say nothing to people: with which of the robot's devices. */
const DEVICES = new Set(["Arm", "Base", "Camera", "Gripper"]);

/** Says a step by a sentence such as "{Robot} drives to {Location}"; without one, by the skill's name and arguments. */
export function stepPieces(step: Step, sentences: Readonly<Record<string, string>>): StepPiece[] {
  const sentence = sentences[step.skill];
  if (sentence === undefined || !isFilled(sentence, step)) return plainly(step);
  return sentence
    .split(/(\{\w+\})/)
    .filter((part) => part !== "")
    .map((part) => (part.startsWith("{") ? { id: step.arguments[part.slice(1, -1)] ?? "" } : { text: part }));
}

function isFilled(sentence: string, step: Step): boolean {
  return [...sentence.matchAll(/\{(\w+)\}/g)].every(([, name]) => (name ?? "") in step.arguments);
}

function plainly({ skill, arguments: given }: Step): StepPiece[] {
  const told = Object.entries(given).filter(([name]) => !DEVICES.has(name));
  return [{ text: skill }, ...told.flatMap(([name, id]): StepPiece[] => [{ text: ` ${name}: ` }, { id }])];
}

/** Counts how many steps of a plan have been done; each step that was run counts for one of the plan. */
export function doneOf(plan: readonly Step[], run: readonly RunStep[]): number {
  const left = run.filter(({ ended }) => ended === "ended");
  return plan.filter((step) => {
    const at = left.findLastIndex((one) => isDone(step, one));
    if (at >= 0) left.splice(at, 1);
    return at >= 0;
  }).length;
}

/** What the plan left open is filled in when a step starts. */
function isDone(planned: Step, ran: Step): boolean {
  const given = Object.entries(planned.arguments);
  return planned.skill === ran.skill && given.every(([name, value]) => ran.arguments[name] === value);
}

/** A step that was run, as a task reports it: ended, failed, cancelled, or null while it runs. */
type RunStep = Step & Pick<Schema<"TaskStep">, "ended">;

/** Minutes and seconds: "1:05". */
export function clock(seconds: number): string {
  const whole = Math.round(seconds);
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")}`;
}
