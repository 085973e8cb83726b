/** The reasons why there is no plan, from the server's data. */

import type { Preview } from "./preview";

/** The kinds of causes that have a headline. */
const KINDS = [
  "no skill",
  "missing fact",
  "missing element",
  "too few",
  "full",
  "does not fit",
  "contradiction",
  "conflict",
] as const;

export interface Cause {
  /** Null for a kind introduced by a later server. */
  kind: (typeof KINDS)[number] | null;
  /** The complete text. */
  text: string;
  /** The core of the text; empty if the conditions say everything. */
  why: string;
  conditions: readonly string[];
  /** Ids of elements and names of classes that it mentions. */
  named: readonly string[];
}

/** Parses a cause; missing fields become empty. */
export function causeOf(data: Preview["causes"][number]): Cause {
  const text = textOf(data.text);
  return {
    kind: KINDS.find((kind) => kind === data.kind) ?? null,
    text,
    why: typeof data.why === "string" ? data.why : text,
    conditions: textsOf(data.conditions),
    named: textsOf(data.elements),
  };
}

function textOf(value: unknown): string {
  return typeof value === "string" ? value : "";
}

function textsOf(value: unknown): string[] {
  return Array.isArray(value) ? value.filter((one) => typeof one === "string") : [];
}

/** The names in a sentence, and the text between them. */
export type Piece = { text: string } | { name: string } | { condition: string };

const WORD = /[\p{L}\p{N}_#]+(?:[.-][\p{L}\p{N}_#]+)*(?:\([^()]*\))?/gu;

/**
 * Splits a sentence at the names in it: ids, classes without prefix, and conditions, "Holding(gripper_1, starter_1)".
 *
 * @param names - The names to look for.
 * @param isElement - Whether any other word is an id.
 * @param isCondition - Whether a word before brackets is a condition.
 */
export function namedIn(
  sentence: string,
  names: readonly string[],
  isElement: (word: string) => boolean,
  isCondition: (word: string) => boolean = () => false,
): Piece[] {
  const known = new Map(names.map((name) => [name.slice(name.lastIndexOf(":") + 1), name]));
  const pieces: Piece[] = [];
  let end = 0;
  for (const { 0: word, index } of sentence.matchAll(WORD)) {
    const [bare = ""] = word.split("(");
    const name = known.get(bare) ?? (isElement(bare) ? bare : undefined);
    const piece = bare !== word && isCondition(bare) ? { condition: word } : name === undefined ? null : { name };
    if (piece === null) continue;
    if (index > end) pieces.push({ text: sentence.slice(end, index) });
    pieces.push(piece);
    end = index + ("name" in piece ? bare : word).length;
  }
  return end < sentence.length ? [...pieces, { text: sentence.slice(end) }] : pieces;
}
