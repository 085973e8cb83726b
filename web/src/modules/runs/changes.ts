/** The changes of the world by a run, as lines of text. */

import { type Edit, editText, type EditText } from "../../widgets/edits";
import { isPose, poseText } from "../../world/values";
import type { Run } from "../queries";

export interface ChangeLine extends EditText {
  key: string;
}

/** Returns a line for each edit, oldest first. */
export function changeLines(changes: Run["changes"]): ChangeLine[] {
  return changes.flatMap((change) => {
    const edits = Array.isArray(change["edits"]) ? (change["edits"] as Edit[]) : [];
    return edits.map((edit, index) => ({ key: `${String(change["number"])}-${index}`, ...editText(edit) }));
  });
}

/** Returns a short text for a value: numbers rounded, components in a row. */
export function shown(value: unknown): string {
  if (value === null || value === undefined) return "–";
  if (typeof value === "number") return String(Math.round(value * 1e4) / 1e4);
  if (Array.isArray(value)) return `(${value.map(shown).join(", ")})`;
  if (isPose(value)) return poseText(value);
  if (typeof value === "object") return Object.values(value).map(shown).join(" ");
  return String(value);
}
