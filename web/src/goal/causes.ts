/** Why there is no plan, as the server's data says it. */

import type { Preview } from "./preview";

/** The kinds of causes for which there is a headline. */
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
  /** Null for one of a later server. */
  kind: (typeof KINDS)[number] | null;
  /** The whole of it. */
  text: string;
  /** The heart of it; empty where the conditions say all. */
  why: string;
  conditions: readonly string[];
  /** Ids of elements and names of classes that it speaks of. */
  named: readonly string[];
}

/** Reads a cause; what is not there is empty. */
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

/** The things that a sentence names, and the words between them. */
export type Piece = { text: string } | { name: string };

const WORD = /[\p{L}\p{N}_#]+(?:[.-][\p{L}\p{N}_#]+)*/gu;

/**
 * Takes a sentence to pieces at the names in it: ids, and classes without the prefix of their ontology.
 *
 * @param names - Those that it may speak of.
 * @param isElement - Tells of any other word whether it is an id.
 */
export function namedIn(sentence: string, names: readonly string[], isElement: (word: string) => boolean): Piece[] {
  const known = new Map(names.map((name) => [name.slice(name.lastIndexOf(":") + 1), name]));
  const pieces: Piece[] = [];
  let end = 0;
  for (const { 0: word, index } of sentence.matchAll(WORD)) {
    const name = known.get(word) ?? (isElement(word) ? word : undefined);
    if (name === undefined) continue;
    if (index > end) pieces.push({ text: sentence.slice(end, index) });
    pieces.push({ name });
    end = index + word.length;
  }
  return end < sentence.length ? [...pieces, { text: sentence.slice(end) }] : pieces;
}
