/** Poses in the API's format, as matrices, and as numbers for people. */

import { Euler, MathUtils, Matrix4, Quaternion, Vector3 } from "three";
import type { Schema } from "../api/client";
import type { MapPose } from "./tools";

export type PoseInfo = Schema<"PoseInfo">;

/** Numbers for people: position [m] and rotations about the fixed axes x, y, z [degrees]. */
export interface PoseNumbers {
  x: number;
  y: number;
  z: number;
  roll: number;
  pitch: number;
  yaw: number;
}

const position = new Vector3();
const orientation = new Quaternion();
const scale = new Vector3();
const ONE = new Vector3(1, 1, 1);

export function matrixOf(pose: PoseInfo | MapPose, into = new Matrix4()): Matrix4 {
  return into.compose(position.fromArray(pose.position), orientation.fromArray(pose.orientation), ONE);
}

export function poseOf(matrix: Matrix4): MapPose {
  matrix.decompose(position, orientation, scale);
  const { x, y, z, w } = orientation.normalize();
  return { position: [position.x, position.y, position.z], orientation: [x, y, z, w] };
}

/** A pose as seven numbers: position [m], and a quaternion x, y, z, w. */
export function poseMatrix([x = 0, y = 0, z = 0, ...turned]: readonly number[], into = new Matrix4()): Matrix4 {
  return into.compose(position.set(x, y, z), orientation.fromArray(turned), ONE);
}

/** Heading of a pose on the floor [rad]. */
export function headingOf(pose: PoseInfo | MapPose): number {
  const [x, y, z, w] = pose.orientation;
  return Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
}

export function numbersOf(pose: MapPose): PoseNumbers {
  const [x, y, z] = pose.position;
  const turns = new Euler().setFromQuaternion(new Quaternion(...pose.orientation), "ZYX");
  const degrees = (angle: number) => rounded(MathUtils.radToDeg(angle), 2);
  const metres = (length: number) => rounded(length, 4);
  const place = { x: metres(x), y: metres(y), z: metres(z) };
  return { ...place, roll: degrees(turns.x), pitch: degrees(turns.y), yaw: degrees(turns.z) };
}

export function poseFrom(numbers: PoseNumbers): MapPose {
  const radians = [numbers.roll, numbers.pitch, numbers.yaw].map((angle) => MathUtils.degToRad(angle));
  const [x, y, z, w] = new Quaternion().setFromEuler(new Euler(radians[0], radians[1], radians[2], "ZYX")).toArray();
  return { position: [numbers.x, numbers.y, numbers.z], orientation: [x, y, z, w] };
}

/** A map pose relative to a frame given in the map; null for the map itself. */
export function seenFrom(pose: MapPose, frame: MapPose | null): MapPose {
  if (frame === null) return pose;
  return poseOf(matrixOf(frame).invert().multiply(matrixOf(pose)));
}

/** Converts a pose in a frame to the map. */
export function inMap(pose: MapPose, frame: MapPose | null): MapPose {
  if (frame === null) return pose;
  return poseOf(matrixOf(frame).multiply(matrixOf(pose)));
}

function rounded(value: number, digits: number): number {
  return Number(value.toFixed(digits)) + 0; // no -0
}
