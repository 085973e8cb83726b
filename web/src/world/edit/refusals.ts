/** What a refusal says of each field, in words for the user. */

import { ApiProblem } from "../../api/client";
import { type FieldFault, faultText } from "../../widgets/faults";
import { problemText } from "../../widgets/problems";
import { type Draft, LABEL, PLACEMENT, reasons } from "./draft";

export interface Refusal {
  byField: Record<string, string>;
  /** What it says of no field. */
  rest: string[];
}

interface Fault {
  /** Names from the field on: which form of value was tried, and where in it. */
  place: string[];
  message: string;
}

/**
 * Returns what a refusal says.
 *
 * @param notAccepted - Says of a field that its value is none that the server takes.
 */
export function refusalOf(error: Error | null, draft: Draft, notAccepted: (field: string) => string): Refusal {
  if (error === null) return { byField: {}, rest: [] };
  const told = error instanceof ApiProblem ? (error.details?.errors ?? []) : [];
  if (told.length === 0) return reasons(problemText(error), Object.keys(draft));
  const faults = new Map<string, Fault[]>();
  const rest: string[] = [];
  for (const fault of told as unknown as FieldFault[]) {
    const [name, place] = placeOf(fault.field, draft);
    const message = faultText(fault);
    if (name === undefined) rest.push(`${fault.field.replace(/^body\./, "")}: ${message}`);
    else faults.set(name, [...(faults.get(name) ?? []), { place, message }]);
  }
  const byField = [...faults].map(([name, all]) => [name, wordsOf(all) ?? notAccepted(name)]);
  return { byField: Object.fromEntries(byField), rest };
}

/** Finds the field of a draft that "body.properties.sk:pose.GivenPose.position.0" is about, and what comes after it. */
function placeOf(path: string, draft: Draft): [string | undefined, string[]] {
  const wire = (name: string) =>
    name === LABEL ? "body.label" : name === PLACEMENT ? "body.placement" : `body.properties.${name}`;
  const name = Object.keys(draft).find((one) => `${path}.`.startsWith(`${wire(one)}.`));
  if (name === undefined) return [undefined, []];
  return [
    name,
    path
      .slice(wire(name).length + 1)
      .split(".")
      .filter(Boolean),
  ];
}

const AXES = ["x", "y", "z"];

/** A value of several forms is refused by each: the one that looked deepest is the one that was meant; or none was. */
function wordsOf(faults: readonly Fault[]): string | undefined {
  const inside = faults.filter(({ place }) => place.length > 1);
  if (inside.length === 0) return faults.length === 1 ? faults[0]?.message : undefined;
  return inside.map(({ place, message }) => `${nameOf(place.slice(1))}: ${message}`).join("; ");
}

function nameOf(place: readonly string[]): string {
  const [part, index] = place;
  return (part === "position" && AXES[Number(index)]) || place.join(" ");
}
