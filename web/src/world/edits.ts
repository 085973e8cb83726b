/** The edits of a change, one line each. */

import type { Edit } from "./tree/concerned";
import { written } from "./values";

type Words = Parameters<typeof written>[1];

/** Returns whether an edit is about an element. */
export function isAbout(edit: Edit, element: string): boolean {
  return [edit.element, edit.subject, edit.object].includes(element);
}

/** Writes an edit in the notation of differences: added (+), removed (-), changed (~). */
export function editLine(edit: Edit, words: Words): string {
  const { element = "", subject = "", relation = "", object = "", property = "" } = edit;
  if (edit.edit === "element") return edit.new === null ? `- ${nameOf(edit.old)}` : `+ ${nameOf(edit.new)}`;
  if (edit.edit === "relation") return `${edit.new ? "+" : "-"} ${subject} ${relation} ${object}`;
  return `~ ${element} ${property}: ${written(edit.old, words)} → ${written(edit.new, words)}`.replace(" :", ":");
}

function nameOf(element: unknown): string {
  const { id, label, type } = element as { id: string; label: string; type: string };
  return label === id ? `${id} (${type})` : `${id} “${label}” (${type})`;
}
