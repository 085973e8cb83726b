/** The latest state of the robots. */

import { create } from "zustand";
import type { Schema } from "../api/client";

export type StationState = Schema<"StationState">;

interface Station {
  /** The latest state; null before the first one. The 3D view reads it once a frame, with `useStation.getState()`. */
  state: StationState | null;
  /** Time of its arrival [ms, performance.now()]. */
  at: number;
  take: (state: StationState) => void;
}

export const useStation = create<Station>((set) => ({
  state: null,
  at: 0,
  take: (state) => set({ state, at: performance.now() }),
}));

/** Whether a module or task runs, during which the scene must not be changed. */
export function useWorks(): boolean {
  return useStation(({ state }) => (state?.modules.length ?? 0) + (state?.tasks.length ?? 0) > 0);
}
