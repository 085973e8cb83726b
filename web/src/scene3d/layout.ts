/** Where elements are drawn: in the map, on a carrying device, in a hand; above their place if the pose is unknown. */

import { type Box3, Matrix4, Vector3 } from "three";
import { matrixOf } from "./pose";
import type { View, ViewElement } from "./view";

/** The frame of an element: "map" never moves; others are ids of devices, such as a base or a gripper. */
export interface Frame {
  on: "map" | "carrier" | "tool";
  id: string;
}

export interface Item {
  element: ViewElement;
  frame: Frame;
  /** Pose in the frame. */
  matrix: Matrix4;
  /** Whether the pose is known; otherwise the element is drawn above its place. */
  sure: boolean;
}

const MAP: Frame = { on: "map", id: "" };
const ABOVE = 0.08; // m, of elements without a known pose above their place
const APART = 0.04; // m between elements without a known pose
const SMALL = 0.05; // m, width of elements without a shape

type Bounds = (element: ViewElement) => Box3 | null;
type Carries = (id: string) => boolean;

/** Computes the layout of a view.
 *
 * @param bounds - Returns the bounding box of an element's shape, in its frame; null without a shape.
 * @param carries - Whether an element is a device that carries bodies: it is drawn at its frame.
 */
export function layout(view: View, bounds: Bounds, carries: Carries = () => false): Map<string, Item> {
  const items = new Map<string, Item>();
  const waiting = new Map<string, ViewElement[]>();
  for (const element of view.elements.values()) {
    const item = known(element, view, carries);
    if (item !== null) items.set(element.id, item);
    else if (element.place !== null) put(waiting, element.place, element);
  }
  for (const place of placesInOrder(waiting)) {
    const at = items.get(place);
    if (at === undefined) continue;
    for (const item of standIns(at, waiting.get(place) ?? [], bounds)) items.set(item.element.id, item);
  }
  return items;
}

/** Orders places before their content, since an element without a known pose may contain others. */
function placesInOrder(waiting: ReadonlyMap<string, ViewElement[]>): string[] {
  const inside = new Map([...waiting].flatMap(([place, there]) => there.map(({ id }) => [id, place] as const)));
  const depth = (place: string): number => {
    let [steps, current] = [0, inside.get(place)];
    for (; current !== undefined && steps < inside.size; steps++) current = inside.get(current);
    return steps;
  };
  return [...waiting.keys()].sort((one, other) => depth(one) - depth(other));
}

function known(element: ViewElement, view: View, carries: Carries): Item | null {
  if (element.kind === "robot") return onRobot(element, view);
  if (element.held_by !== null) {
    const matrix = element.in_hand ? matrixOf(element.in_hand) : new Matrix4();
    return { element, frame: { on: "tool", id: element.held_by }, matrix, sure: true };
  }
  if (carries(element.id)) {
    return { element, frame: { on: "carrier", id: element.id }, matrix: new Matrix4(), sure: true };
  }
  if (element.pose === null) return null;
  const frame: Frame = element.carrier ? { on: "carrier", id: element.carrier } : MAP;
  return { element, frame, matrix: matrixOf(element.pose), sure: true };
}

function onRobot(element: ViewElement, view: View): Item | null {
  for (const { id, owner, kind, shape, pose, carrier } of view.elements.values()) {
    const isBase = owner === element.id && kind === "device" && shape === null && pose !== null && !carrier;
    if (isBase) return { element, frame: { on: "carrier", id }, matrix: new Matrix4(), sure: true };
  }
  return element.pose === null ? null : { element, frame: MAP, matrix: matrixOf(element.pose), sure: true };
}

function standIns(place: Item, elements: readonly ViewElement[], bounds: Bounds): Item[] {
  const spots = rows(
    bounds(place.element),
    elements.map((element) => bounds(element)),
  );
  return elements.map((element, i) => {
    const matrix = new Matrix4().makeTranslation(spots[i] ?? new Vector3()).premultiply(place.matrix);
    return { element, frame: place.frame, matrix, sure: false };
  });
}

/** Positions above a place for elements of these sizes, in its frame: in rows along its longer side. */
export function rows(place: Box3 | null, things: readonly (Box3 | null)[], lift = ABOVE): Vector3[] {
  const size = place?.getSize(new Vector3()) ?? new Vector3();
  const middle = place?.getCenter(new Vector3()) ?? new Vector3();
  const step = Math.max(SMALL, ...things.map(widthOf)) + APART;
  const along = size.y >= size.x ? "y" : "x";
  const perRow = Math.max(1, Math.floor(size[along] / step));
  const perLayer = perRow * Math.max(1, Math.floor(size[along === "y" ? "x" : "y"] / step));
  const top = (place?.max.z ?? 0) + lift;
  return things.map((thing, i) => {
    const [layer, rest] = [Math.floor(i / perLayer), i % perLayer];
    const inLayer = Math.min(perLayer, things.length - layer * perLayer);
    const [row, column] = [Math.floor(rest / perRow), rest % perRow];
    const inRow = Math.min(perRow, inLayer - row * perRow);
    const rowsThere = Math.ceil(inLayer / perRow);
    const a = (column - (inRow - 1) / 2) * step;
    const b = (row - (rowsThere - 1) / 2) * step;
    const height = top + layer * step - (thing?.min.z ?? 0);
    return along === "y"
      ? new Vector3(middle.x + b, middle.y + a, height)
      : new Vector3(middle.x + a, middle.y + b, height);
  });
}

function widthOf(box: Box3 | null): number {
  if (box === null) return SMALL;
  const size = box.getSize(new Vector3());
  return Math.max(size.x, size.y);
}

function put<Value>(map: Map<string, Value[]>, key: string, value: Value): void {
  const there = map.get(key);
  if (there === undefined) map.set(key, [value]);
  else there.push(value);
}
