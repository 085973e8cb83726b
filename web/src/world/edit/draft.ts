/** Unsaved edits of an element, merged with concurrent changes by others. */

import type { Schema } from "../../api/client";
import type { Details, Placement } from "../queries";
import { isPose } from "../values";
import { byName } from "../../widgets/names";

type Patch = Schema<"ElementPatch">;
type GivenValue = NonNullable<Patch["properties"]>[string];

export const LABEL = "rdfs:label";
export const PLACEMENT = "sk:placement";
const POSE = "sk:pose";

/** The editable data: label, placement, and own values by property; missing keys have no own value. */
export type Draft = Readonly<Record<string, unknown>>;

export function draftOf(element: Details): Draft {
  const own = Object.entries(element.properties).filter(([, property]) => property.origin === "own");
  return {
    [LABEL]: element.label,
    [PLACEMENT]: element.placement,
    ...Object.fromEntries(own.map(([name, { value }]) => [name, value])),
  };
}

export function without(draft: Draft, field: string): Draft {
  return Object.fromEntries(Object.entries(draft).filter(([name]) => name !== field));
}

/** Returns the fields that differ. */
export function changedFields(before: Draft, after: Draft): string[] {
  const fields = new Set([...Object.keys(before), ...Object.keys(after)]);
  return [...fields].filter((field) => !same(before[field], after[field]));
}

/** Returns the request that turns one version into the other. */
export function patchOf(before: Draft, after: Draft, reason: string): Patch {
  const fields = changedFields(before, after);
  const properties = fields.filter((field) => field !== LABEL && field !== PLACEMENT);
  return {
    ...(fields.includes(LABEL) && { label: String(after[LABEL]) }),
    ...(fields.includes(PLACEMENT) && { placement: after[PLACEMENT] as Placement | null }),
    ...(properties.length > 0 && {
      properties: Object.fromEntries(properties.map((name) => [name, given(name, after[name])])),
    }),
    reason,
  };
}

/** Returns a value in the server's format: null removes the own value. */
export function given(name: string, value: unknown): GivenValue {
  if (value === undefined || value === "") return null;
  // Without a frame the server keeps the old one, but here a missing frame means the map.
  const written = name === POSE && isPose(value) ? { ...value, frame: value.frame ?? null } : value;
  return written as GivenValue;
}

/** Returns the fields that cannot be saved, because a number is missing or malformed. */
export function unfitFields(draft: Draft): string[] {
  return Object.keys(draft).filter((field) => hasNaN(draft[field]));
}

function hasNaN(value: unknown): boolean {
  if (typeof value === "object" && value !== null) return Object.values(value).some(hasNaN);
  return Number.isNaN(value);
}

/** A field that I or others have changed since I began. */
export interface Difference {
  field: string;
  was: unknown;
  theirs: unknown;
  mine: unknown;
  /** I changed it; otherwise the others' value is kept. */
  byMe: boolean;
  /** Both changed it, to different values. */
  clash: boolean;
}

/** Compares my edits with the changes that others made meanwhile. */
export function differences(before: Draft, theirs: Draft, mine: Draft): Difference[] {
  const byThem = new Set(changedFields(before, theirs));
  const byMe = new Set(changedFields(before, mine));
  return [...new Set([...byThem, ...byMe])].map((field) => ({
    field,
    was: before[field],
    theirs: theirs[field],
    mine: mine[field],
    byMe: byMe.has(field),
    clash: byThem.has(field) && byMe.has(field) && !same(theirs[field], mine[field]),
  }));
}

/** Applies my edits to the others' version. */
export function onTop(before: Draft, mine: Draft, theirs: Draft): Draft {
  return changedFields(before, mine).reduce(
    (draft, field) => (mine[field] === undefined ? without(draft, field) : { ...draft, [field]: mine[field] }),
    theirs,
  );
}

/** Returns the refusals of each field, and the remaining ones. */
export function reasons(
  detail: string,
  fields: readonly string[],
): { byField: Record<string, string>; rest: string[] } {
  const lines = detail.split("\n").map((line) => line.replace(/^\s*-\s*/, "").trim());
  const byField: Record<string, string> = {};
  const rest: string[] = [];
  for (const line of lines.filter(Boolean)) {
    const field = fields.find((name) => mentions(line, name));
    if (field === undefined) rest.push(line);
    else byField[field] = [byField[field], line].filter(Boolean).join("; ");
  }
  return { byField, rest: rest.filter((line) => !(line.endsWith("refused:") && lines.length > 1)) };
}

function mentions(line: string, field: string): boolean {
  if (field === LABEL) return /\blabel\b/.test(line);
  return new RegExp(`(^|[^\\w:])${field.replace(/[.*+?^${}()|[\]\\]/g, "\\$&")}($|[^\\w])`).test(line);
}

function same(one: unknown, other: unknown): boolean {
  return JSON.stringify(sorted(one)) === JSON.stringify(sorted(other));
}

/** Poses in the map are read without a frame, and written with null. */
function sorted(value: unknown): unknown {
  if (typeof value !== "object" || value === null || Array.isArray(value)) return value;
  const entries = Object.entries(value).filter(([, one]) => one !== null && one !== undefined);
  return Object.fromEntries(entries.sort(([a], [b]) => byName(a, b)));
}
