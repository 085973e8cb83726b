/** Surfaces on which a moved element comes to lie. */

import { Box3 } from "three";
import { crowd } from "../elements/crowd";
import { matrixOf } from "../pose";
import type { MapPose } from "../tools";

const NEAR = 0.04; // m from a surface, to which the handles snap

/** A solid by its bounding box, or a cavity, whose bottom counts. */
export interface Ground {
  box: Box3;
  hollow: boolean;
}

/** Height of the surface at a point [m]: that of a cavity there, otherwise of the highest solid, otherwise the floor. */
export function surfaceAt(grounds: readonly Ground[], [x, y]: readonly number[]): number {
  const below = grounds.filter(({ box }) => inside(box, Number(x), Number(y)));
  const cavity = below.find(({ hollow }) => hollow);
  return cavity?.box.min.z ?? Math.max(0, ...below.map(({ box }) => box.max.z));
}

function inside({ min, max }: Box3, x: number, y: number): boolean {
  return x > min.x && x < max.x && y > min.y && y < max.y;
}

/** The pose at which an element lies on the surface below its frame. */
export function setDown(id: string, pose: MapPose): MapPose {
  const bounds = crowd.shapeOf(id)?.bounds;
  if (bounds === undefined) return pose;
  const [x, y, z] = pose.position;
  const bottom = new Box3().copy(bounds).applyMatrix4(matrixOf(pose)).min.z;
  return { ...pose, position: [x, y, z + surfaceAt(groundsWithout(id), pose.position) - bottom] };
}

/** The pose on a surface that is near, otherwise the same. */
export function snapped(id: string, pose: MapPose): MapPose {
  const down = setDown(id, pose);
  return Math.abs(down.position[2] - pose.position[2]) < NEAR ? down : pose;
}

function groundsWithout(id: string): Ground[] {
  return [...crowd.items()].flatMap(({ element }) => {
    const box = element.id === id || element.held_by !== null ? null : crowd.boundsOf(element.id);
    return box === null ? [] : [{ box, hollow: element.hollow }];
  });
}
