/** The changes of the world by a run, as lines of text. */

import type { Run } from "../queries";

export interface ChangeLine {
  key: string;
  /** The changed element; empty if there is none. */
  element: string;
  text: string;
}

interface Edit {
  edit: string;
  [field: string]: unknown;
}

/** Returns a line for each edit, oldest first. */
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

/** Returns a short text for a value: numbers rounded, components in a row. */
export function shown(value: unknown): string {
  if (value === null || value === undefined) return "–";
  if (typeof value === "number") return String(Math.round(value * 1e4) / 1e4);
  if (Array.isArray(value)) return `(${value.map(shown).join(", ")})`;
  if (typeof value === "object") return Object.values(value).map(shown).join(" ");
  return String(value);
}
