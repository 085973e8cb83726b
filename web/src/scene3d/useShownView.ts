import { useMemo } from "react";
import { useReplay } from "./replay";
import { PastViews } from "./replayFrames";
import { useLiveView, type View } from "./view";

/** The drawn world: the present, or that of the replay at its time. */
export function useShownView(): View | null {
  const live = useLiveView((state) => state.view);
  const piece = useReplay((state) => (state.replay === null ? null : state.piece));
  const past = useMemo(() => (piece === null ? null : new PastViews(piece)), [piece]);
  const then = useReplay((state) => past?.at(state.time) ?? null);
  return then ?? live;
}
