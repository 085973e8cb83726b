/** The drawn models, and the poses of their robots. */

import { Matrix4, type Vector3 } from "three";
import type { URDFRobot } from "urdf-loader";
import { create } from "zustand";
import { deviceInMap } from "../frames";
import { matrixOf } from "../pose";
import { disposeModel } from "./model";
import type { RobotInfo } from "../../api/cell";

/** Drawn models by the id of the robot, or of the device without a robot. */
export const useModels = create<Readonly<Record<string, URDFRobot>>>(() => ({}));

/** Registers a drawn model; returns the function that removes it. */
export function addModel(id: string, model: URDFRobot): () => void {
  useModels.setState({ [id]: model });
  return () => {
    const { [id]: gone, ...others } = useModels.getState();
    useModels.setState(others, true);
    if (gone !== undefined) disposeModel(gone);
  };
}

/** The devices that move robots through the map, by robot id. */
export const carrierOf = new Map<string, string>();

/** Registers the device that moves a robot through the map; returns the function that removes it. */
export function noteCarrier({ id, carrier }: RobotInfo): () => void {
  if (carrier !== null) carrierOf.set(id, carrier);
  return () => carrierOf.delete(id);
}

/** Writes the pose of a robot in the map; false if unknown. */
export function robotInMap({ carrier, place }: RobotInfo, into: Matrix4): boolean {
  if (carrier !== null) return deviceInMap(carrier, into);
  if (place) matrixOf(place, into);
  return place !== null;
}

const MIDDLE = 0.45; // m: only the footprint of a robot is known
const TOP = 1.1; // m
const here = new Matrix4();

/** Writes a point of a robot in the map; false if it is not a mobile robot. */
export function robotPoint(robot: string, into: Vector3, top: boolean): boolean {
  const carrier = carrierOf.get(robot);
  if (carrier === undefined || !deviceInMap(carrier, here)) return false;
  into.setFromMatrixPosition(here).z += top ? TOP : MIDDLE;
  return true;
}
