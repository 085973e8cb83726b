/** The command palette; its code comes when it is opened first. */

import { create } from "zustand";

interface Palette {
  /** How often it was opened. */
  asked: number;
  open: () => void;
}

export const usePalette = create<Palette>((set) => ({
  asked: 0,
  open: () => set(({ asked }) => ({ asked: asked + 1 })),
}));
