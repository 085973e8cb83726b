/** A past job that is shown in the 3D view instead of the present. */

import { create } from "zustand";
import type { Schema } from "../api/client";

interface Replay {
  /** What is shown again; null for the present. */
  replay: Schema<"Replay"> | null;
  /** The moment that is shown [s, run time of the replay]. */
  time: number;
  /** How fast it goes on; 0 while it stands. */
  speed: number;
  set: (change: Partial<Omit<Replay, "set">>) => void;
}

export const useReplay = create<Replay>((set) => ({ replay: null, time: 0, speed: 0, set: (change) => set(change) }));
