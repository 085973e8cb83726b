/** What the pointer does in the 3D view besides selecting. */

import { create } from "zustand";

/** `belief` changes what the robots believe (the scene); `body` moves the simulated thing without the robots knowing. */
export type Tool = "select" | "belief" | "body";
export type GizmoMode = "translate" | "rotate";

export interface MapPose {
  position: [number, number, number];
  /** Unit quaternion (x, y, z, w). */
  orientation: [number, number, number, number];
}

interface Tools {
  tool: Tool;
  mode: GizmoMode;
  /** Steps of the gizmo [m] and [rad]; 0 for none. */
  snap: { translate: number; rotate: number };
  /** The pose that the gizmo or the numbers have by now, not yet written; null while nothing is moved. */
  draft: { element: string; pose: MapPose } | null;
  set: (change: Partial<Omit<Tools, "set">>) => void;
}

export const useTools = create<Tools>((set) => ({
  tool: "select",
  mode: "translate",
  snap: { translate: 0.01, rotate: Math.PI / 36 },
  draft: null,
  set: (change) => set(change),
}));
