/** Where frames are in the frame that is drawn: bases from their numbers, tools from the robots' models. */

import { Matrix4, type Object3D } from "three";
import { useStation } from "../live/station";
import { devices } from "./devices";
import type { Frame } from "./layout";
import { matrixOf, planarMatrix } from "./pose";

const IDENTITY = new Matrix4();

/** The links that are the tools of grippers, of the models that are drawn. */
const tools = new Map<string, Object3D>();
/** The arms of grippers, for robots without a model. */
const armOf = new Map<string, string>();

/** Says which link is the tool of a gripper; returns how to take that back. */
export function bearTool(gripper: string, arm: string, link: Object3D | null): () => void {
  armOf.set(gripper, arm);
  if (link !== null) tools.set(gripper, link);
  return () => {
    armOf.delete(gripper);
    tools.delete(gripper);
  };
}

/** Writes where a frame is in the map; false where that is unknown. */
export function frameInMap(frame: Frame, into: Matrix4): boolean {
  if (frame.on === "map") into.copy(IDENTITY);
  else if (frame.on === "base") return baseInMap(frame.id, into);
  else return toolInMap(frame.id, into);
  return true;
}

function baseInMap(id: string, into: Matrix4): boolean {
  const numbers = devices.bases[id];
  if (numbers === undefined) return false;
  planarMatrix(numbers, into);
  return true;
}

function toolInMap(gripper: string, into: Matrix4): boolean {
  const link = tools.get(gripper);
  if (link !== undefined) {
    into.copy(link.matrixWorld);
    return true;
  }
  const pose = useStation.getState().state?.arms[armOf.get(gripper) ?? ""]?.tool;
  if (!pose) return false;
  matrixOf(pose, into);
  return true;
}
