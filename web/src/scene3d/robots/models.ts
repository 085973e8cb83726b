/** The models that are drawn, by the ids of their robots, and where the robots and their joints are. */

import { Matrix4, type Vector3 } from "three";
import type { URDFRobot } from "urdf-loader";
import { deviceInMap } from "../frames";
import { matrixOf } from "../pose";
import type { RobotInfo } from "./useRobots";

export const models = new Map<string, URDFRobot>();
/** The devices that move robots through the map, by the robots' ids. */
export const carrierOf = new Map<string, string>();

/** The joints that a number of a device moves, for replays: "robot/joint". */
export interface Moved {
  joints: readonly string[];
  /** What part of the number is that of each joint. */
  share: number;
}
export const movedBy = new Map<string, readonly Moved[]>();

/** Notes what moves a robot and its joints; returns how to forget that. */
export function noteRobot({ id, carrier, arms, grippers }: RobotInfo): () => void {
  const own = (name: string) => `${id}/${name}`;
  if (carrier !== null) carrierOf.set(id, carrier);
  for (const arm of arms) {
    const each = arm.joints.map(({ name }) => ({ joints: [own(name)], share: 1 }));
    movedBy.set(arm.id, each);
  }
  for (const { id: gripper, joints = [] } of grippers) {
    movedBy.set(gripper, [{ joints: joints.map(own), share: 1 / 2 }]);
  }
  return () => {
    carrierOf.delete(id);
    for (const device of [...arms, ...grippers]) movedBy.delete(device.id);
  };
}

/** Writes where a robot is in the map; false where that is unknown. */
export function robotInMap({ carrier, place }: RobotInfo, into: Matrix4): boolean {
  if (carrier !== null) return deviceInMap(carrier, into);
  if (place) matrixOf(place, into);
  return place !== null;
}

const MIDDLE = 0.45; // m: of robots only the footprint is known
const TOP = 1.1; // m
const here = new Matrix4();

/** Writes a point of a robot in the map; false for what is no robot that moves. */
export function robotPoint(robot: string, into: Vector3, top: boolean): boolean {
  const carrier = carrierOf.get(robot);
  if (carrier === undefined || !deviceInMap(carrier, here)) return false;
  into.setFromMatrixPosition(here).z += top ? TOP : MIDDLE;
  return true;
}
