/** The report of a job as text for use elsewhere. */

import type { Schema } from "../api/client";
import type { Skills } from "../api/cell";
import type { Run } from "./trace";
import { span, stepTitle } from "./words";
import { said } from "../i18n/sentences";

export interface ReportWords {
  title: string;
  outcome: string;
  goal: string;
  conditions: string;
  reached: string;
  notReached: string;
  parts: string;
  steps: string;
  done: string;
  reasons: string;
  gone: string;
}

/** Writes a report as Markdown, with user-defined names escaped. */
export function asMarkdown(job: Schema<"Job">, run: Run, skills: Skills, words: ReportWords): string {
  const parts = job.materials.map(
    ({ element, label, origin, place }) =>
      `- ${text(label || element)} (${text(element)}): ${text(origin)} → ${text(place || words.gone)}`,
  );
  const conditions = job.conditions.map(
    ({ condition, reached, reason }) =>
      `- [${reached ? "x" : " "}] ${text(condition)}: ${reached ? words.reached : words.notReached}${reason && ` – ${text(said(reason))}`}`,
  );
  const steps = run.steps.map((step, index) => {
    const took = step.end === null ? "" : ` (${span(step.end - step.start)})`;
    return `${index + 1}. ${text(stepTitle(step, skills))}, ${text(step.agent)}: ${step.ended === "ended" ? words.done : text(said(step.text))}${took}`;
  });
  return [
    `# ${words.title}`,
    `${words.goal}: ${text(job.order.goal.join(", "))}`,
    `**${words.outcome}**`,
    ...section(words.conditions, conditions),
    ...section(words.parts, parts),
    ...section(words.steps, steps),
    ...section(
      words.reasons,
      job.reasons.map((reason) => `- ${text(said(reason))}`),
    ),
    "",
  ].join("\n\n");
}

function section(title: string, lines: readonly string[]): string[] {
  return lines.length === 0 ? [] : [`## ${title}`, lines.join("\n")];
}

function text(plain: string): string {
  return plain.replaceAll(/\s+/g, " ").replaceAll(/[\\`*_<>[\]#|]/g, "\\$&");
}
