/** Optional layers of the 3D view; remembered in this browser. */

import { create } from "zustand";
import { persist } from "zustand/middleware";

export const LAYERS = ["labels", "rooms", "clouds", "seen", "paths", "ghosts", "axes", "grid"] as const;
export type Layer = (typeof LAYERS)[number];

interface Layers {
  shown: Record<Layer, boolean>;
  toggle: (layer: Layer) => void;
}

const ALL: Record<Layer, boolean> = {
  labels: true,
  rooms: true,
  clouds: true,
  seen: true,
  paths: true,
  ghosts: true,
  axes: false,
  grid: true,
};

export const useLayers = create<Layers>()(
  persist(
    (set) => ({
      shown: ALL,
      toggle: (layer) => set(({ shown }) => ({ shown: { ...shown, [layer]: !shown[layer] } })),
    }),
    {
      name: "skiros-layers",
      partialize: ({ shown }) => ({ shown }),
      merge: (kept, now) => ({ ...now, shown: { ...ALL, ...(kept as Partial<Layers> | undefined)?.shown } }),
    },
  ),
);
