/** Frames in the rendered view: from the states of devices, and tools from the robots' models. */

import { Matrix4, type Object3D } from "three";
import { devices } from "./devices";
import type { Frame } from "./layout";
import { poseMatrix } from "./pose";

const IDENTITY = new Matrix4();

/** The tool links of grippers, in the models that are drawn. */
const tools = new Map<string, Object3D>();

/** Registers the tool link of a gripper; returns the function that removes it. */
export function bearTool(gripper: string, link: Object3D): () => void {
  tools.set(gripper, link);
  return () => tools.delete(gripper);
}

/** Writes the pose of a frame in the map; false if unknown. */
export function frameInMap(frame: Frame, into: Matrix4): boolean {
  const link = frame.on === "tool" ? tools.get(frame.id) : undefined;
  if (frame.on === "map") into.copy(IDENTITY);
  else if (link !== undefined) into.copy(link.matrixWorld);
  else return deviceInMap(frame.id, into);
  return true;
}

/** Writes the pose of a device's frame in the map; false if unknown. */
export function deviceInMap(id: string, into: Matrix4): boolean {
  const numbers = devices.frames[id];
  if (numbers === undefined) return false;
  poseMatrix(numbers, into);
  return true;
}
