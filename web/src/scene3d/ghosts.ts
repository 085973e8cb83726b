/** Targets of goals, shown as ghosts in the 3D view while the goal is edited and pursued. */

import { create } from "zustand";

export interface Ghost {
  /** Its key among the ghosts. */
  key: string;
  /** Element or class that has its shape. */
  like: string;
  /** Element that it is to be in, on or at. */
  place: string;
}

interface Ghosts {
  ghosts: readonly Ghost[];
  show: (ghosts: readonly Ghost[]) => void;
}

export const useGhosts = create<Ghosts>((set) => ({ ghosts: [], show: (ghosts) => set({ ghosts }) }));
