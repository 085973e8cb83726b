/** The nodes of the tree affected by a change. */

import { TOP } from "./top";
import type { Placement } from "../queries";

/** One edit of a change, in the format of events and the history. */
export interface Edit {
  edit: string;
  element?: string;
  subject?: string;
  object?: string;
  relation?: string;
  property?: string;
  old: unknown;
  new: unknown;
}

/** Returns the ids removed by a change. */
export function removed(edits: readonly Edit[]): Set<string> {
  const gone = edits.filter((edit) => edit.edit === "element" && edit.new === null);
  return new Set(gone.map((edit) => edit.element ?? ""));
}

/** Returns the nodes whose children, labels or counts have changed. */
export function concerned(edits: readonly Edit[], parents: ReadonlyMap<string, string>): Set<string> {
  const found = new Set<string>();
  for (const name of edits.flatMap(named)) {
    found.add(name);
    const above = parents.get(name);
    if (above !== undefined) found.add(above);
  }
  return found;
}

function named(edit: Edit): string[] {
  const { element = "", subject = "", object = "" } = edit;
  switch (edit.edit) {
    case "element":
      return [element, TOP];
    case "placement":
      return [element, ...places(edit)];
    case "relation":
      return [subject, object];
    case "property":
      return edit.property === "rdfs:label" ? [element] : [];
    default:
      return [];
  }
}

function places(edit: Edit): string[] {
  const both = [edit.old, edit.new] as (Placement | null)[];
  return both.flatMap((placement) => (placement === null ? [TOP] : [placement.place]));
}
