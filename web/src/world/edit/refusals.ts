/** The faults in a refusal by field, in words for people. */

import { ApiProblem } from "../../api/client";
import { type FieldFault, faultText } from "../../widgets/faults";
import { problemText } from "../../widgets/problems";
import { type Draft, LABEL, PLACEMENT, reasons } from "./draft";

export interface Refusal {
  byField: Record<string, string>;
  /** The faults without a field. */
  rest: string[];
}

interface Fault {
  /** The path from the field on: the attempted form of the value, and the position in it. */
  place: string[];
  message: string;
}

/**
 * Returns the faults in a refusal.
 *
 * @param notAccepted - Returns the text for a field whose value has no accepted form.
 */
export function refusalOf(error: Error | null, draft: Draft, notAccepted: (field: string) => string): Refusal {
  if (error === null) return { byField: {}, rest: [] };
  const errors = error instanceof ApiProblem ? (error.details?.errors ?? []) : [];
  if (errors.length === 0) return reasons(problemText(error), Object.keys(draft));
  const faults = new Map<string, Fault[]>();
  const rest: string[] = [];
  for (const fault of errors as unknown as FieldFault[]) {
    const [name, place] = placeOf(fault.field, draft);
    const message = faultText(fault);
    if (name === undefined) rest.push(`${fault.field.replace(/^body\./, "")}: ${message}`);
    else faults.set(name, [...(faults.get(name) ?? []), { place, message }]);
  }
  const byField = [...faults].map(([name, all]) => [name, wordsOf(all) ?? notAccepted(name)]);
  return { byField: Object.fromEntries(byField), rest };
}

/** Finds the field for a path such as "body.properties.sk:pose.GivenPose.position.0", and the rest of the path. */
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

/** Each form of a value reports its own faults: the form with the deepest path was intended; otherwise none was. */
function wordsOf(faults: readonly Fault[]): string | undefined {
  const inside = faults.filter(({ place }) => place.length > 1);
  if (inside.length === 0) return faults.length === 1 ? faults[0]?.message : undefined;
  return inside.map(({ place, message }) => `${nameOf(place.slice(1))}: ${message}`).join("; ");
}

function nameOf(place: readonly string[]): string {
  const [part, index] = place;
  return (part === "position" && AXES[Number(index)]) || place.join(" ");
}
