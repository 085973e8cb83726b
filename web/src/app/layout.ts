/** Whether the 3D view is shown beside the tabs; by default if there is room for both. */

import { useMediaQuery } from "@mantine/hooks";
import { create } from "zustand";

/** A low window, or one that is zoomed in; `app.css` lets the page scroll there. */
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

/** Shows or hides the 3D view, and remembers the choice. */
export function toggleView3d(): void {
  useLayout.getState().toggle();
}
