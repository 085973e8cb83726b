/** Computes camera positions. */

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
const FULL = 0.88; // share of the view that is filled
const CLOSEST = 0.4; // m
const ROUNDS = 3; // iterations for the centre, after which it hardly moves
const NEAR = 0.4; // m: minimum length of the region shown for an element
const ROBOT = 2; // m: length of the region shown around a robot
const SPOT = new Box3(new Vector3(-0.5, -0.5, 0), new Vector3(0.5, 0.5, 1)); // stands in for elements without a shape

/** Camera position for some elements; null if there is nothing to look at. */
export function viewing(wish: Viewpoint, camera: PerspectiveCamera, focus: string | null): Viewing | null {
  if (wish === "overview") return from(ASKEW, everything(), camera);
  if (wish === "top") return from(ABOVE, everything(), camera);
  if (focus === null) return null;
  const direction = camera.getWorldDirection(new Vector3()).negate();
  if (direction.z < 0.2) direction.copy(ASKEW);
  return from(direction, around(focus), camera);
}

function from(direction: Vector3, what: readonly Vector3[], camera: PerspectiveCamera): Viewing | null {
  if (what.length === 0) return null;
  const target = new Box3().setFromPoints([...what]).getCenter(new Vector3());
  const frame = frameFrom(direction, camera);
  for (let i = 0; i < ROUNDS; i++) target.add(offCentre(frame, what, target));
  return { position: eye(frame, what, target), target };
}

/** Axes of the view, and the tangents of half its angles, scaled by the share to fill. */
interface Frame {
  direction: Vector3;
  aside: Vector3;
  upward: Vector3;
  wide: number;
  high: number;
}

function frameFrom(direction: Vector3, camera: PerspectiveCamera): Frame {
  const aside = new Vector3().crossVectors(UP, direction).normalize();
  const upward = new Vector3().crossVectors(direction, aside);
  const high = Math.tan(MathUtils.degToRad(camera.fov / 2)) * FULL;
  return { direction, aside, upward, wide: high * camera.aspect, high };
}

/** Camera position from which all points around a target are visible. */
function eye({ direction, aside, upward, wide, high }: Frame, points: readonly Vector3[], target: Vector3): Vector3 {
  const away = points.reduce((most, point) => {
    const there = new Vector3().subVectors(point, target);
    const needed = Math.max(Math.abs(there.dot(aside)) / wide, Math.abs(there.dot(upward)) / high);
    return Math.max(most, needed + there.dot(direction));
  }, CLOSEST);
  return target.clone().addScaledVector(direction, away);
}

/** Offset of the target from the centre of the projected points: distant points look smaller. */
function offCentre(frame: Frame, points: readonly Vector3[], target: Vector3): Vector3 {
  const from = eye(frame, points, target);
  const away = from.distanceTo(target);
  const seen = new Box3();
  for (const point of points) {
    const there = new Vector3().subVectors(point, from);
    const depth = -there.dot(frame.direction);
    seen.expandByPoint(new Vector3(there.dot(frame.aside) / depth, there.dot(frame.upward) / depth, 0));
  }
  const { x, y } = seen.getCenter(new Vector3());
  return new Vector3().addScaledVector(frame.aside, x * away).addScaledVector(frame.upward, y * away);
}

function corners({ min, max }: Box3): Vector3[] {
  return [min.x, max.x].flatMap((x) => [min.y, max.y].flatMap((y) => [min.z, max.z].map((z) => new Vector3(x, y, z))));
}

/** The corners of everything that stands on the floor, which may be larger than all of it. */
function everything(): Vector3[] {
  const pose = new Matrix4();
  return [...crowd.items()].flatMap(({ element }) => {
    if (element.kind === "floor" || !crowd.poseOf(element.id, pose)) return [];
    const bounds = crowd.shapeOf(element.id)?.bounds ?? SPOT;
    return corners(bounds).map((corner) => corner.applyMatrix4(pose));
  });
}

function around(id: string): Vector3[] {
  const center = new Vector3();
  if (!pointOf(id, "middle", center)) return [];
  const item = crowd.item(id);
  if (item === undefined || item.element.kind === "robot") return cube(center, ROBOT);
  const size = crowd.shapeOf(id)?.bounds.getSize(new Vector3()).length() ?? 0;
  return cube(center, Math.max(size * 1.1, NEAR));
}

function cube(center: Vector3, length: number): Vector3[] {
  return corners(new Box3().setFromCenterAndSize(center, new Vector3(length, length, length)));
}
