/** Whether the 3D view is shown beside the tabs: by itself where there is room for both. */

import { useMediaQuery } from "@mantine/hooks";
import { create } from "zustand";

/** A low window, or one that is zoomed in; `app.css` has the page scroll there. */
const LOW = "(max-height: 32rem)";
const REMEMBERED = { high: "skiros-view3d", low: "skiros-view3d-low" } as const;

type Height = keyof typeof REMEMBERED;

interface Layout extends Record<Height, boolean> {
  toggle: () => void;
}

const useLayout = create<Layout>((set, get) => ({
  high: localStorage.getItem(REMEMBERED.high) !== "hidden",
  low: localStorage.getItem(REMEMBERED.low) === "shown",
  toggle: () => {
    const height: Height = matchMedia(LOW).matches ? "low" : "high";
    const shown = !get()[height];
    localStorage.setItem(REMEMBERED[height], shown ? "shown" : "hidden");
    set({ [height]: shown });
  },
}));

/** Whether the 3D view is shown. */
export function useView3d(): boolean {
  const low = useMediaQuery(LOW, undefined, { getInitialValueInEffect: false });
  return useLayout((layout) => (low ? layout.low : layout.high));
}

/** Shows the 3D view or hides it, and remembers that. */
export function toggleView3d(): void {
  useLayout.getState().toggle();
}
