/** The command palette; its code is loaded when it is first opened. */

import { create } from "zustand";

interface Palette {
  /** Counts how often it was opened. */
  asked: number;
  open: () => void;
}

export const usePalette = create<Palette>((set) => ({
  asked: 0,
  open: () => set(({ asked }) => ({ asked: asked + 1 })),
}));
