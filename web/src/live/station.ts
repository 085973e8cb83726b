/** The latest state of the robots. */

import { create } from "zustand";
import type { Schema } from "../api/client";

export type StationState = Schema<"StationState">;

interface Station {
  /** The latest state; null before the first one. The 3D view reads it once a frame, with `useStation.getState()`. */
  state: StationState | null;
  /** Time of its arrival [ms, performance.now()]. */
  at: number;
  /** Simulated seconds for each second of the last few; null as long as that is unknown. */
  rate: number | null;
  take: (state: StationState) => void;
}

export const useStation = create<Station>((set) => ({
  state: null,
  at: 0,
  rate: null,
  take: (state) => {
    const at = performance.now();
    set({ state, at, rate: measure(state.time, at) });
  },
}));

const [SHORTEST, LONGEST] = [1000, 4000]; // ms over which the pace is measured
let times: { time: number; at: number }[] = [];

function measure(time: number, at: number): number | null {
  if (time < (times.at(-1)?.time ?? 0)) times = []; // another session
  times = [...times.filter((one) => at - one.at <= LONGEST), { time, at }];
  const first = times[0];
  return first === undefined || at - first.at < SHORTEST ? null : (1000 * (time - first.time)) / (at - first.at);
}

/** Whether a module or task runs, during which the scene must not be changed. */
export function useWorks(): boolean {
  return useStation(({ state }) => (state?.modules.length ?? 0) + (state?.tasks.length ?? 0) > 0);
}
