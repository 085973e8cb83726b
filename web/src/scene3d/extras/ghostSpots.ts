/** The poses of ghosts: in free compartments of their place, or on it. */

import { type Box3, Matrix4, Vector3 } from "three";
import type { Ghost } from "../ghosts";
import { rows } from "../layout";
import type { View, ViewElement } from "../view";

export interface GhostSpot {
  ghost: Ghost;
  /** Key of the shape. */
  shape: string;
  /** The frame that it moves with, and its pose in that frame. */
  anchor: string;
  matrix: Matrix4;
}

type Bounds = (shape: string) => Box3 | null;

/** Finds a pose for each ghost whose shape and place are known. */
export function ghostSpots(ghosts: readonly Ghost[], view: View, bounds: Bounds): GhostSpot[] {
  const taken = new Set<string>();
  const onPlace = new Map<string, { ghost: Ghost; shape: string }[]>();
  const spots: GhostSpot[] = [];
  for (const ghost of ghosts) {
    const shape = shapeLike(ghost.like, view);
    if (shape === null || !view.elements.has(ghost.place) || isThere(ghost, view)) continue;
    const room = roomIn(ghost.place, view, taken);
    if (room === null) onPlace.set(ghost.place, [...(onPlace.get(ghost.place) ?? []), { ghost, shape }]);
    else spots.push(inRoom(ghost, shape, room, bounds));
    if (room !== null) taken.add(room.id);
  }
  for (const [place, there] of onPlace) spots.push(...onTop(place, there, view, bounds));
  return spots;
}

/** Key of the shape of an element, or of a class by its name with or without prefix. */
export function shapeLike(like: string, view: View): string | null {
  const element = view.elements.get(like);
  if (element !== undefined) return element.shape;
  return Object.keys(view.shapes).find((key) => key === like || key.endsWith(`:${like}`)) ?? null;
}

function isThere({ like, place }: Ghost, view: View): boolean {
  const element = view.elements.get(like);
  return element !== undefined && (element.place === place || view.elements.get(element.place ?? "")?.owner === place);
}

/** The place itself if it is a compartment, otherwise a free one that belongs to it; null for none. */
function roomIn(place: string, view: View, taken: ReadonlySet<string>): ViewElement | null {
  const itself = view.elements.get(place);
  if (itself?.hollow === true) return itself;
  const full = new Set([...view.elements.values()].map((element) => element.place));
  for (const element of view.elements.values()) {
    if (element.owner === place && element.hollow && !full.has(element.id) && !taken.has(element.id)) return element;
  }
  return null;
}

function inRoom(ghost: Ghost, shape: string, room: ViewElement, bounds: Bounds): GhostSpot {
  const floor = bounds(room.shape ?? "")?.min.z ?? 0;
  const middle = bounds(room.shape ?? "")?.getCenter(new Vector3()) ?? new Vector3();
  const height = floor - (bounds(shape)?.min.z ?? 0);
  return { ghost, shape, anchor: room.id, matrix: new Matrix4().makeTranslation(middle.x, middle.y, height) };
}

function onTop(
  place: string,
  there: readonly { ghost: Ghost; shape: string }[],
  view: View,
  bounds: Bounds,
): GhostSpot[] {
  const under = bounds(view.elements.get(place)?.shape ?? "");
  const sizes = there.map(({ shape }) => bounds(shape));
  return rows(under, sizes, 0).map((spot, i) => {
    const { ghost, shape } = there[i] ?? { ghost: { key: "", like: "", place }, shape: "" };
    return { ghost, shape, anchor: place, matrix: new Matrix4().makeTranslation(spot) };
  });
}
