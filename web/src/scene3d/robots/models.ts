/** The models that are drawn, by the ids of their robots, and where the robots stand. */

import type { Vector3 } from "three";
import type { URDFRobot } from "urdf-loader";
import type { Devices } from "../devices";

export const models = new Map<string, URDFRobot>();
/** The bases of robots, by the robots' ids. */
export const baseOf = new Map<string, string>();

const MIDDLE = 0.45; // m: of robots only the footprint is known
const TOP = 1.1; // m

/** Writes a point of a robot in the map; false for what is no robot. */
export function robotPose(robot: string, bases: Devices["bases"], into: Vector3, top: boolean): boolean {
  const place = bases[baseOf.get(robot) ?? ""];
  if (place === undefined) return false;
  into.set(place[0] ?? 0, place[1] ?? 0, top ? TOP : MIDDLE);
  return true;
}
