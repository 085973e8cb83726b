/** The selection, shared by tree, 3D view and lists; and the pick for which a form waits. */

import { create } from "zustand";

/** A form field that waits for a click on an element, in 3D or in the tree. */
export interface Pick {
  /** Its purpose, for people: "Kit of InKit". */
  purpose: string;
  /** Returns whether an element can be picked. */
  fits: (id: string) => boolean;
  take: (id: string) => void;
}

interface Selection {
  selected: string | null;
  hovered: string | null;
  pick: Pick | null;
  /** Selects an element, or passes it to the waiting pick. */
  choose: (id: string | null) => void;
  hover: (id: string | null) => void;
  /** Waits for a click; replaces an earlier pick. */
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
