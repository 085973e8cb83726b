/** Hit tests, and positions of elements on the page. */

import { type Camera, type Intersection, type Object3D, Matrix4, Raycaster, Vector2, Vector3 } from "three";
import { crowd } from "./elements/crowd";
import { robotPoint } from "./robots/models";

const raycaster = new Raycaster();
const point = new Vector2();
const place = new Matrix4();
const middle = new Vector3();

export interface Spot {
  x: number;
  y: number;
}

/** Id of the nearest suitable element at a position of the page; null for none. */
export function elementAt(spot: Spot, canvas: HTMLElement, camera: Camera, among: Object3D): string | null {
  const { left, top, width, height } = canvas.getBoundingClientRect();
  point.set(((spot.x - left) / width) * 2 - 1, 1 - ((spot.y - top) / height) * 2);
  raycaster.setFromCamera(point, camera);
  let room: string | null = null;
  for (const hit of raycaster.intersectObject(among, true)) {
    const id = idOf(hit);
    if (id === null) continue;
    if (crowd.item(id)?.element.hollow !== true) return floorLast(room, id);
    room ??= id; // compartments let the pointer through to their content
  }
  return room;
}

/** A compartment takes precedence over its owner, and content over its compartment. */
function floorLast(room: string | null, matter: string): string {
  if (room === null) return matter;
  const owner = crowd.item(room)?.element.owner;
  const element = crowd.item(matter)?.element;
  return element?.kind === "part" ? matter : matter === owner || element?.kind === "floor" ? room : matter;
}

function idOf({ object, instanceId }: Intersection): string | null {
  const ids = object.userData["ids"] as string[] | undefined;
  if (ids !== undefined) return ids[instanceId ?? -1] ?? null;
  for (let current: Object3D | null = object; current !== null; current = current.parent) {
    const id: unknown = current.userData["element"];
    if (typeof id === "string") return id;
  }
  return null;
}

/** Writes a point of an element in the map: its centre, or the centre of its upper side; false without a pose. */
export function pointOf(id: string, at: "middle" | "top", into: Vector3): boolean {
  if (robotPoint(id, into, at === "top")) return true;
  if (!crowd.poseOf(id, place)) return false;
  const bounds = crowd.shapeOf(id)?.bounds;
  if (bounds === undefined) into.set(0, 0, 0);
  else bounds.getCenter(into);
  into.applyMatrix4(place);
  if (at === "top" && bounds !== undefined) into.z += (bounds.max.z - bounds.min.z) / 2;
  return true;
}

/** Position of a map point in the view [px]; null behind the camera. */
export function onPicture(point: Vector3, camera: Camera, width: number, height: number): Spot | null {
  middle.copy(point).project(camera);
  if (middle.z > 1) return null;
  return { x: ((middle.x + 1) / 2) * width, y: ((1 - middle.y) / 2) * height };
}
