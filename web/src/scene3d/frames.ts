/** Where frames are in the picture that is drawn: as devices say, and tools where the robots' models have them. */

import { Matrix4, type Object3D } from "three";
import { devices } from "./devices";
import type { Frame } from "./layout";
import { poseMatrix } from "./pose";

const IDENTITY = new Matrix4();

/** The links that are the tools of grippers, of the models that are drawn. */
const tools = new Map<string, Object3D>();

/** Says which link is the tool of a gripper; returns how to take that back. */
export function bearTool(gripper: string, link: Object3D): () => void {
  tools.set(gripper, link);
  return () => tools.delete(gripper);
}

/** Writes where a frame is in the map; false where that is unknown. */
export function frameInMap(frame: Frame, into: Matrix4): boolean {
  const link = frame.on === "tool" ? tools.get(frame.id) : undefined;
  if (frame.on === "map") into.copy(IDENTITY);
  else if (link !== undefined) into.copy(link.matrixWorld);
  else return deviceInMap(frame.id, into);
  return true;
}

/** Writes where the frame of a device is in the map; false where that is unknown. */
export function deviceInMap(id: string, into: Matrix4): boolean {
  const numbers = devices.frames[id];
  if (numbers === undefined) return false;
  poseMatrix(numbers, into);
  return true;
}
