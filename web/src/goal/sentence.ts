/** Conditions as sentences: text with slots. */

import type { Schema } from "../api/client";
import { localName } from "../widgets/names";

export type ConditionWord = Schema<"ConditionWord">;
type Role = Schema<"Role">;

/** A part of a sentence: text, or the slot of a role (by its index). */
export type Piece = string | number;

/** Splits a sentence such as "{object} lies in {location}" into text and slots; roles not named are appended. */
export function piecesOf(sentence: string, roles: readonly Pick<Role, "name">[]): Piece[] {
  const left = new Set(roles.keys());
  const pieces = sentence.split(/(\{\w+\})/).map((part): Piece => {
    const index = roles.findIndex(({ name }) => part === `{${name}}`);
    if (!left.delete(index)) return part.replaceAll(/[{}]/g, "");
    return index;
  });
  const missing = [...left].flatMap((index): Piece[] => [`, ${roles[index]?.name}:`, index]);
  return [...pieces, ...missing].filter((piece) => typeof piece === "number" || piece.trim() !== "");
}

/**
 * Makes a sentence with slots from the help of a condition: "The object lies in the container." becomes "{object} lies
 * in {location}" if the role "location" has the class Container. Null if a role is not mentioned.
 */
export function sentenceOfHelp({ help, roles }: Pick<ConditionWord, "help" | "roles">): string | null {
  let sentence = help.trim().replace(/\.$/, "");
  for (const { name, class: class_ } of roles) {
    const slotted = slotted1(sentence, name, [name, localName(class_)]);
    if (slotted === null) return null;
    sentence = slotted;
  }
  return sentence;
}

function slotted1(sentence: string, role: string, nouns: readonly string[]): string | null {
  for (const noun of nouns) {
    const spoken = noun.replaceAll(/([a-z])([A-Z])/g, "$1 $2").replaceAll("_", " ");
    const match = new RegExp(`\\b(the|a|an) ${spoken}\\b`, "i").exec(sentence);
    if (match) return `${sentence.slice(0, match.index)}{${role}}${sentence.slice(match.index + match[0].length)}`;
  }
  return null;
}

/** A generic sentence for a condition without one: "Name, first: …, second: …". */
export function plainSentence({ name, roles }: Pick<ConditionWord, "name" | "roles">): string {
  return [name, ...roles.map((role) => `${role.name}: {${role.name}}`)].join(", ").replace(",", ":");
}
