/** Targets of goals, shown as ghosts in the 3D view before and while they are pursued. */

import { create } from "zustand";

export interface Ghost {
  /** Names it among the ghosts. */
  key: string;
  /** Element or class whose shape it has. */
  like: string;
  /** Element that it is to be in, on or at. */
  place: string;
}

interface Ghosts {
  ghosts: readonly Ghost[];
  show: (ghosts: readonly Ghost[]) => void;
}

export const useGhosts = create<Ghosts>((set) => ({ ghosts: [], show: (ghosts) => set({ ghosts }) }));
