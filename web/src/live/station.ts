/** What the robots do at this moment: the latest only. */

import { create } from "zustand";
import type { Schema } from "../api/client";

export type StationState = Schema<"StationState">;

interface Station {
  /** The latest state; null until there is one. The 3D view reads it once a frame, with `useStation.getState()`. */
  state: StationState | null;
  /** When it came [ms, performance.now()]. */
  at: number;
  take: (state: StationState) => void;
}

export const useStation = create<Station>((set) => ({
  state: null,
  at: 0,
  take: (state) => set({ state, at: performance.now() }),
}));

/** Whether anything runs, which the world may not be changed under. */
export function useWorks(): boolean {
  return useStation(({ state }) => (state?.modules.length ?? 0) + (state?.tasks.length ?? 0) > 0);
}
