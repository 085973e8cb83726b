/** Possible placements, by the ontology alone; and the server's check of one place. */

import { said } from "../../i18n/sentences";
import { answer, api, type Schema } from "../../api/client";
import { ancestors, type Classes } from "../classes";
import type { RelationInfo } from "../queries";

type Ends = readonly (readonly string[])[];

/** The guest of a placement: an element, or a new one of a class. */
export type Guest = { element: string } | { class: string };

/** Returns whether a class may be an end of a relation: at least one class of each group must be it or an ancestor. */
export function fitsEnd(classes: Classes, name: string, end: Ends): boolean {
  const above = new Set(ancestors(classes, name));
  return end.every((group) => group.some((one) => above.has(one)));
}

export function guestEnd(relation: RelationInfo): Ends {
  return relation.place_end === "subject" ? relation.objects : relation.subjects;
}

export function placeEnd(relation: RelationInfo): Ends {
  return relation.place_end === "subject" ? relation.subjects : relation.objects;
}

/** The common placement relations, most common first; "held by" is left to robots. */
const USUAL = ["sk:in", "sk:on", "sk:at"];
const UNUSUAL = "sk:heldBy";

/**
 * Returns the relations by which elements of a class can be placed, optionally at places of a class.
 *
 * The first one is the default.
 */
export function placementsFor(
  classes: Classes,
  relations: readonly RelationInfo[],
  guest: string,
  place?: string,
): RelationInfo[] {
  const found = relations.filter(
    (relation) =>
      relation.place_end !== null &&
      relation.name !== "sk:placement" &&
      fitsEnd(classes, guest, guestEnd(relation)) &&
      (place === undefined || fitsEnd(classes, place, placeEnd(relation))),
  );
  return found.sort((one, other) => unusualness(one) - unusualness(other));
}

function unusualness({ name }: RelationInfo): number {
  if (name === UNUSUAL) return USUAL.length + 1;
  const rank = USUAL.indexOf(name);
  return rank < 0 ? USUAL.length : rank;
}

/** The result for one guest, place and relation. */
export interface Fit {
  relation: string;
  label: string;
  fits: boolean;
  whyNot: string;
  /** Whether skills need elements of this class to be placed by it. */
  accepted: boolean;
}

/** The relation for a move: what skills accept, otherwise the present one; undefined if it has to be asked. */
export function relationFor(fits: readonly Fit[], present: string | undefined): string | undefined {
  const possible = fits.filter((fit) => fit.fits);
  return (possible.find(({ accepted }) => accepted) ?? possible.find(({ relation }) => relation === present))?.relation;
}

/** Checks whether a place accepts a guest by each relation; omits those by which it accepts nothing of that class. */
export async function askFits(guest: Guest, place: string, relations: readonly string[]): Promise<Fit[]> {
  const found = await Promise.all(relations.map((relation) => askFit(guest, place, relation)));
  return found.filter((fit) => fit !== null);
}

async function askFit(guest: Guest, place: string, relation: string): Promise<Fit | null> {
  const query = { ...guest, relation, limit: 1, cursor: justBefore(place) };
  const { options } = await answer(api.GET("/api/v1/ontology/placements", { params: { query } }));
  return fitAt(options, place);
}

function fitAt(options: readonly Schema<"PlacementOption">[], place: string): Fit | null {
  for (const { relation, label, accepted, places } of options) {
    const found = places.find((one) => one.id === place);
    if (found !== undefined) return { relation, label, accepted, fits: found.fits, whyNot: said(found.why_not) };
  }
  return null;
}

/** A cursor just before an id: places are sorted by id, and checking all of them would take long. */
export function justBefore(id: string): string {
  const last = id.charCodeAt(id.length - 1);
  return `${id.slice(0, -1)}${String.fromCharCode(last - 1)}\uffff`;
}
