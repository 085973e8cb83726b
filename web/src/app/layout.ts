/** Whether the 3D view is shown beside the tabs; by default if there is room for both. */

import { useMediaQuery } from "@mantine/hooks";
import { create } from "zustand";

/** A low window, which `app.css` lets scroll, a narrow one, or one that is zoomed in. */
const SMALL = "(max-height: 32rem), (max-width: 30rem)";
const REMEMBERED = { large: "skiros-view3d", small: "skiros-view3d-low" } as const;

type Size = keyof typeof REMEMBERED;

interface Layout extends Record<Size, boolean> {
  toggle: () => void;
}

const useLayout = create<Layout>((set, get) => ({
  large: localStorage.getItem(REMEMBERED.large) !== "hidden",
  small: localStorage.getItem(REMEMBERED.small) === "shown",
  toggle: () => {
    const size: Size = matchMedia(SMALL).matches ? "small" : "large";
    const shown = !get()[size];
    localStorage.setItem(REMEMBERED[size], shown ? "shown" : "hidden");
    set({ [size]: shown });
  },
}));

/** Whether the 3D view is shown. */
export function useView3d(): boolean {
  const small = useMediaQuery(SMALL, undefined, { getInitialValueInEffect: false });
  return useLayout((layout) => (small ? layout.small : layout.large));
}

/** Shows or hides the 3D view, and remembers the choice. */
export function toggleView3d(): void {
  useLayout.getState().toggle();
}
