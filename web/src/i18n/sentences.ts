/** Sentences by the server, said in the language of the pages from what they are made of. */

import i18n, { type Language } from ".";
import type { components } from "../api/schema";
import { onEvent } from "../live/events";
import german from "./de/server.json";

type Parts = components["schemas"]["SentenceParts"];

/**
 * Translations by template, where a sentence is not shown as the server says it. Lists of known names help
 * programmers, but hide the problem from operators.
 */
const CATALOGUES: Record<Language, Record<string, string>> = { de: german, en: { "Known: {names}.": "" } };

const TERMS = new Set(["relation", "there", "property", "kind", "wanted", "choice"]);
const NUMBER = /^-?\d+\.\d+$/;
const MOST = 20_000;

/** Parts of the sentences in recent answers and events, by sentence. */
const learnt = new Map<string, Parts>();

/** Learns what the sentences in an answer or event of the server are made of. */
export function learn(data: unknown): void {
  if (Array.isArray(data)) return data.forEach(learn);
  if (typeof data !== "object" || data === null) return;
  if ("texts" in data) {
    for (const [text, parts] of Object.entries(data.texts as Record<string, Parts>)) {
      learnt.delete(text); // to the end: the oldest are forgotten first
      learnt.set(text, parts);
    }
    for (const oldest of learnt.keys()) {
      if (learnt.size <= MOST) break;
      learnt.delete(oldest);
    }
  }
  if ("items" in data) learn(data.items);
  if ("entries" in data) learn(data.entries);
  if ("data" in data) learn(data.data);
  if ("job" in data) learn(data.job);
}

// Registered here: the shared worker reads events, too, and has no language.
onEvent((event) => learn(event.data));

/** A sentence in the language of the pages; as it is, if it cannot be translated. */
export function said(text: string): string {
  return translated(learnt.get(text) ?? { template: text, values: {} });
}

function translated({ template, values }: Parts): string {
  const own = CATALOGUES[i18n.language as Language][template] ?? template;
  return own
    .replaceAll(/\{(\w+)\}/g, (field, name: string) => (name in values ? word(name, values[name]) : field))
    .trim();
}

function word(name: string, value: unknown): string {
  if (typeof value === "object") return translated(value as Parts);
  const text = String(value);
  if (NUMBER.test(text)) return text.replace(".", i18n.language === "de" ? "," : ".");
  const terms: Record<string, string> = i18n.t("terms", { returnObjects: true });
  return TERMS.has(name) ? (terms[camelCase(text.replace(/^\w+:/, ""))] ?? text) : text;
}

/** The label of a relation or property as its name: "held by" becomes "heldBy". */
function camelCase(label: string): string {
  return label.replaceAll(/ (\w)/g, (_, letter: string) => letter.toUpperCase());
}
