/** Whether the 3D view is shown beside the tabs. */

import { create } from "zustand";

const REMEMBERED = "skiros-view3d";

interface Layout {
  view3d: boolean;
  toggle: () => void;
}

export const useLayout = create<Layout>((set, get) => ({
  view3d: localStorage.getItem(REMEMBERED) !== "hidden",
  toggle: () => {
    const view3d = !get().view3d;
    localStorage.setItem(REMEMBERED, view3d ? "shown" : "hidden");
    set({ view3d });
  },
}));
