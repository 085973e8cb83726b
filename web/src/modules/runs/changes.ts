/** What a run wrote into the world, in lines for people. */

import type { Run } from "../queries";

export interface ChangeLine {
  key: string;
  /** Element that was changed; empty where it is about none. */
  element: string;
  text: string;
}

interface Edit {
  edit: string;
  [field: string]: unknown;
}

/** Returns a line for each edit, the youngest last. */
export function changeLines(changes: Run["changes"]): ChangeLine[] {
  return changes.flatMap((change) => {
    const edits = Array.isArray(change["edits"]) ? (change["edits"] as Edit[]) : [];
    return edits.map((edit, index) => ({
      key: `${String(change["number"])}-${index}`,
      element: String(edit["element"] ?? edit["subject"] ?? ""),
      text: `${what(edit)}: ${shown(edit["old"])} → ${shown(edit["new"])}`,
    }));
  });
}

function what(edit: Edit): string {
  const words = [edit.edit, edit["property"], edit["relation"], edit["object"]];
  return words.filter((word) => typeof word === "string").join(" ");
}

/** Returns a value of an edit in few words: numbers rounded, parts one after the other. */
export function shown(value: unknown): string {
  if (value === null || value === undefined) return "–";
  if (typeof value === "number") return String(Math.round(value * 1e4) / 1e4);
  if (Array.isArray(value)) return `(${value.map(shown).join(", ")})`;
  if (typeof value === "object") return Object.values(value).map(shown).join(" ");
  return String(value);
}
