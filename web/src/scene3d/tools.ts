/** The pointer tools of the 3D view. */

import { create } from "zustand";

/** `belief` changes the scene that the robots believe; `body` moves the simulated body without informing the robots. */
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
  /** Step sizes of the gizmo [m] and [rad]; 0 for none. */
  snap: { translate: number; rotate: number };
  /** The edited pose, not written yet; null while nothing is moved. */
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
