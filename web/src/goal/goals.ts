/** A goal as a list of conditions that must hold together: the editor's rows, and the data sent to the server. */

import type { Schema } from "../api/client";

/** A structured condition, as the server reads and writes it. */
export type GoalData = Record<string, unknown>;
/** A condition as the server accepts it: structured, or as text. */
export type Goal = string | GoalData;
export type GoalOrder = Schema<"GoalOrder">;
export type CheckedCondition = Schema<"CheckedCondition">;

/** A condition as a sentence with slots. */
export interface WordRow {
  key: string;
  kind: "word";
  /** The condition's name ("InKit"). */
  word: string;
  /** Ids of elements, or classes; null for an empty slot. */
  arguments: (string | null)[];
  /** Whether it is negated. */
  not: boolean;
}

/** A condition that is more than one sentence, as text. */
export interface TextRow {
  key: string;
  kind: "text";
  text: string;
}

export type Row = WordRow | TextRow;

/** A row without a key. */
export type NewRow = Omit<WordRow, "key"> | Omit<TextRow, "key">;

let last = 0;

/** Gives rows the keys that identify them on the page. */
export function keyed(rows: readonly NewRow[]): Row[] {
  return rows.map((row) => ({ ...row, key: `${Date.now().toString(36)}-${++last}` }));
}

/** The server's form of a row; null while it is incomplete. */
export function goalOf(row: Row): Goal | null {
  if (row.kind === "text") return row.text.trim() || null;
  if (row.arguments.some((argument) => !argument)) return null;
  const data = { condition: row.word, arguments: row.arguments };
  return row.not ? { not: data } : data;
}

/** The goal of all rows; null while it is empty or incomplete. */
export function goalOrder(rows: readonly Row[]): GoalOrder | null {
  const goals = rows.map(goalOf);
  const complete = goals.filter((goal) => goal !== null);
  if (goals.length === 0 || complete.length < goals.length) return null;
  return { goal: complete, work_master: "", parameters: {}, materials: [] };
}

/** Rows for conditions parsed by the server: a sentence for a single word, otherwise text. */
export function rowOf({ data, text }: Pick<CheckedCondition, "data" | "text">): NewRow {
  const not = "not" in data;
  const inner = not ? data.not : data;
  if (!isWord(inner)) return { kind: "text", text };
  return { kind: "word", word: inner.condition, arguments: inner.arguments, not };
}

interface Word {
  condition: string;
  arguments: string[];
}

/** Whether a structured condition is a single word with names. */
export function isWord(data: unknown): data is Word {
  if (typeof data !== "object" || data === null || !("condition" in data && "arguments" in data)) return false;
  return Array.isArray(data.arguments) && data.arguments.every((argument) => typeof argument === "string");
}

/** The text of a row in the goal language. */
export function textOf(row: NewRow): string {
  if (row.kind === "text") return row.text;
  const names = row.arguments.map((argument) => quoted(argument ?? "?"));
  return `${row.not ? "not " : ""}${row.word}(${names.join(", ")})`;
}

const PLAIN = /^[\p{L}_](?:[\p{L}\p{N}_.-]|:(?=[\p{L}\p{N}_]))*$/u;

function quoted(name: string): string {
  return PLAIN.test(name) || name === "?" ? name : `"${name.replaceAll(/["\\]/g, "\\$&")}"`;
}

/** Parses a condition's text as far as possible here: a single word with plain names; others stay text. */
export function readRow(text: string): NewRow {
  const match = /^(not )?(\w+)\(([^()"]*)\)$/.exec(text.trim());
  if (match === null) return { kind: "text", text };
  const [, not, word = "", names = ""] = match;
  return { kind: "word", word, arguments: names.split(",").map((name) => name.trim()), not: not !== undefined };
}

/** A condition's text without prefixes, as explanations write it. */
export function shortText(text: string): string {
  return text.replaceAll(/(?<![\w"])[A-Za-z_][\w.-]*:(?=\w)/g, "");
}

/** The short form of a condition, for comparing answers of the server. */
export function isSame(text: string, other: string): boolean {
  return shortText(text).replaceAll(/\s+/g, "") === shortText(other).replaceAll(/\s+/g, "");
}

/** The row for a condition in short form: completed from a condition of the goal if it is one. */
export function rowOfShort(text: string, conditions: readonly CheckedCondition[]): NewRow {
  const same = conditions.find((one) => isSame(one.text, text));
  if (same !== undefined) return rowOf(same);
  const row = readRow(text);
  return row.kind === "text" ? row : { ...row, arguments: row.arguments.map((name) => wholeName(name, conditions)) };
}

/** A name with its prefix, if one of the conditions contains it so. */
function wholeName(name: string | null, conditions: readonly CheckedCondition[]): string | null {
  return conditions.flatMap(namesIn).find((one) => shortText(one) === name) ?? name;
}

/** The elements and classes that a condition names; unknown unless it is a single word. */
export function namesIn(condition: Pick<CheckedCondition, "data" | "text">): string[] {
  const row = rowOf(condition);
  return row.kind === "word" ? row.arguments.filter((name) => name !== null) : [];
}

/** The reason why a condition holds or not, without the condition itself. */
export function whyAlone({ text, why }: Pick<CheckedCondition, "text" | "why">): string {
  const itself = `${shortText(text)}: `;
  return why.startsWith(itself) ? why.slice(itself.length) : why;
}

interface Changed {
  without: readonly string[];
  instead: readonly { condition: string; by: string }[];
}

/** The goal after applying a proposal; null if the proposal is about a condition that is no longer in the goal. */
export function repaired(conditions: readonly CheckedCondition[], { without, instead }: Changed): NewRow[] | null {
  const spoken = [...without, ...instead.map(({ condition }) => condition)];
  if (!spoken.every((one) => conditions.some(({ text }) => isSame(text, one)))) return null;
  const left = conditions.filter(({ text }) => !without.some((one) => isSame(one, text)));
  return left.map((condition) => {
    const exchange = instead.find((one) => isSame(one.condition, condition.text));
    return exchange === undefined ? rowOf(condition) : rowOfShort(exchange.by, conditions);
  });
}
