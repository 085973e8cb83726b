/** What is selected, in the tree, in 3D and in the lists alike; and a pick that some form waits for. */

import { create } from "zustand";

/** A slot that waits for an element to be clicked, in 3D or in the tree. */
export interface Pick {
  /** What for, to be read by a person: "Kit of InKit". */
  purpose: string;
  /** Returns whether an element fits. */
  fits: (id: string) => boolean;
  take: (id: string) => void;
}

interface Selection {
  selected: string | null;
  hovered: string | null;
  pick: Pick | null;
  /** Selects an element, or hands it to the slot that waits for a pick. */
  choose: (id: string | null) => void;
  hover: (id: string | null) => void;
  /** Waits for a click; another wait ends the one before. */
  awaitPick: (pick: Pick) => void;
  endPick: () => void;
}

export const useSelection = create<Selection>((set, get) => ({
  selected: null,
  hovered: null,
  pick: null,
  choose: (id) => {
    const { pick } = get();
    if (pick === null || id === null) {
      set({ selected: id });
    } else if (pick.fits(id)) {
      set({ pick: null });
      pick.take(id);
    }
  },
  hover: (id) => set({ hovered: id }),
  awaitPick: (pick) => set({ pick }),
  endPick: () => set({ pick: null }),
}));
