/** Works out where a camera has to be to see something. */

import { Box3, MathUtils, Matrix4, type PerspectiveCamera, Vector3 } from "three";
import { crowd } from "../elements/crowd";
import { pointOf } from "../pointing";
import type { Viewpoint } from "./camera";

export interface Viewing {
  position: Vector3;
  target: Vector3;
}

const ASKEW = new Vector3(0.45, -0.85, 0.75).normalize();
const ABOVE = new Vector3(0, -0.001, 1).normalize();
const UP = new Vector3(0, 0, 1);
const FULL = 0.88; // of the picture is filled
const CLOSEST = 0.4; // m
const NEAR = 0.4; // m: length of what is looked at closely, at least
const ROBOT = 2; // m: length that is seen around a robot
const SPOT = new Box3(new Vector3(-0.5, -0.5, 0), new Vector3(0.5, 0.5, 1)); // around what has no shape

/** Where to look from; null where there is nothing to look at. */
export function viewing(wish: Viewpoint, camera: PerspectiveCamera, focus: string | null): Viewing | null {
  if (wish === "overview") return from(ASKEW, everything(), camera);
  if (wish === "top") return from(ABOVE, everything(), camera);
  if (focus === null) return null;
  const direction = camera.getWorldDirection(new Vector3()).negate();
  if (direction.z < 0.2) direction.copy(ASKEW);
  return from(direction, around(focus), camera);
}

function from(direction: Vector3, what: Box3 | null, camera: PerspectiveCamera): Viewing | null {
  if (what === null) return null;
  const target = what.getCenter(new Vector3());
  const position = target.clone().addScaledVector(direction, distance(direction, what, target, camera));
  return { position, target };
}

/** How far away all corners of a box are in the picture [m]. */
function distance(direction: Vector3, box: Box3, target: Vector3, camera: PerspectiveCamera): number {
  const aside = new Vector3().crossVectors(UP, direction).normalize();
  const upward = new Vector3().crossVectors(direction, aside);
  const high = Math.tan(MathUtils.degToRad(camera.fov / 2)) * FULL;
  const wide = high * camera.aspect;
  const needs = corners(box).map((corner) => {
    corner.sub(target);
    const needed = Math.max(Math.abs(corner.dot(aside)) / wide, Math.abs(corner.dot(upward)) / high);
    return needed + corner.dot(direction);
  });
  return Math.max(...needs, CLOSEST);
}

function corners({ min, max }: Box3): Vector3[] {
  const [low, high] = [min, max];
  return [low.x, high.x].flatMap((x) =>
    [low.y, high.y].flatMap((y) => [low.z, high.z].map((z) => new Vector3(x, y, z))),
  );
}

/** What stands around; the floor may be larger than all of it. */
function everything(): Box3 | null {
  const box = new Box3();
  const pose = new Matrix4();
  for (const { element } of crowd.items()) {
    if (element.kind === "floor" || !crowd.poseOf(element.id, pose)) continue;
    const bounds = crowd.shapeOf(element.id)?.bounds ?? SPOT;
    box.union(bounds.clone().applyMatrix4(pose));
  }
  return box.isEmpty() ? null : box;
}

function around(id: string): Box3 | null {
  const center = new Vector3();
  if (!pointOf(id, "middle", center)) return null;
  const item = crowd.item(id);
  if (item === undefined || item.element.kind === "robot") return cube(center, ROBOT);
  const size = crowd.shapeOf(id)?.bounds.getSize(new Vector3()).length() ?? 0;
  return cube(center, Math.max(size * 1.1, NEAR));
}

function cube(center: Vector3, length: number): Box3 {
  return new Box3().setFromCenterAndSize(center, new Vector3(length, length, length));
}
