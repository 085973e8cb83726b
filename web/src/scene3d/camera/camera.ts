/** The requested viewpoint. */

import { create } from "zustand";

export const VIEWPOINTS = ["overview", "top", "follow", "selection"] as const;
export type Viewpoint = (typeof VIEWPOINTS)[number];

interface Camera {
  viewpoint: Viewpoint;
  /** Counts the requests, so that the same one can be repeated. */
  requests: number;
  look: (viewpoint: Viewpoint) => void;
}

export const useCamera = create<Camera>((set) => ({
  viewpoint: "overview",
  requests: 0,
  look: (viewpoint) => set(({ requests }) => ({ viewpoint, requests: requests + 1 })),
}));
