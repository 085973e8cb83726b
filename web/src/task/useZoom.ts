/** The visible part of a timeline: a window with readable bars that follows the present, a selected range, or all. */

import { useCallback, useEffect, useRef, useState } from "react";
import type { Span } from "./schedule";

const CLOSEST = 1; // s
const STEP = 1.5;
const AHEAD = 0.5; // share of the window before the present

export interface Zoom extends Span {
  /** Whether the window follows the present. */
  follows: boolean;
  zoom: (factor: number, around?: number) => void;
  move: (share: number) => void;
  all: () => void;
  follow: (on: boolean) => void;
}

/**
 * Returns the visible window of the timeline `whole`.
 *
 * @param readable - Length of a window whose bars have room for their texts [s]; the first one shown.
 * @param now - The present [s]; null for ended runs, which are shown from their start.
 */
export function useZoom(whole: Span, readable: number, now: number | null): Zoom {
  const [chosen, choose] = useState<Span | "first" | "whole">("first");
  const [follows, setFollows] = useState(true);
  const window_ = windowOf(whole, chosen === "first" ? firstOf(whole, readable) : chosen, follows ? now : null);
  const all = () => {
    choose("whole");
    setFollows(false);
  };
  const middle = (window_.start + window_.end) / 2;
  const zoom = (factor: number, around = follows ? (now ?? middle) : middle) => {
    const next = zoomed(window_, factor, around);
    const shown = next.end - next.start;
    if (shown >= whole.end - whole.start) all();
    else choose(shown < CLOSEST ? window_ : next);
  };
  const move = (share: number) => {
    const by = (window_.end - window_.start) * share;
    setFollows(false);
    choose({ start: window_.start + by, end: window_.end + by });
  };
  const follow = (on: boolean) => {
    choose(on ? "first" : window_);
    setFollows(on);
  };
  return { ...window_, follows, zoom, move, all, follow };
}

function firstOf(whole: Span, readable: number): Span | "whole" {
  return whole.end - whole.start <= readable ? "whole" : { start: whole.start, end: whole.start + readable };
}

/** @param around - The present, if the window follows it. */
export function windowOf(whole: Span, chosen: Span | "whole", around: number | null): Span {
  if (chosen === "whole") return whole;
  if (around === null) return chosen;
  const wide = chosen.end - chosen.start;
  const start = Math.max(whole.start, Math.min(around - AHEAD * wide, whole.end - wide));
  return { start, end: start + wide };
}

/** Returns a window narrower by `factor`, in which one time keeps its position. */
export function zoomed(window_: Span, factor: number, around: number): Span {
  return { start: around - (around - window_.start) / factor, end: around + (window_.end - around) / factor };
}

/** Zooms around the pointer with Ctrl and the wheel, or by pinching; the wheel alone scrolls the page. */
export function useWheelZoom<E extends Element>(momentAt: (x: number) => number, zoom: Zoom["zoom"]) {
  const element = useRef<E>(null);
  const turn = useRef<(event: WheelEvent) => void>(() => undefined);
  useEffect(() => {
    turn.current = (event) => {
      if (!event.ctrlKey && !event.metaKey && !event.shiftKey) return;
      event.preventDefault();
      const turned = event.deltaY || event.deltaX; // with Shift, browsers scroll sideways
      const left = element.current?.getBoundingClientRect().left ?? 0;
      zoom(turned < 0 ? STEP : 1 / STEP, momentAt(event.clientX - left));
    };
  });
  const listen = useCallback((event: Event) => turn.current(event as WheelEvent), []);
  useEffect(() => {
    const drawn = element.current;
    drawn?.addEventListener("wheel", listen, { passive: false }); // React's own listener cannot prevent scrolling
    return () => drawn?.removeEventListener("wheel", listen);
  }, [listen]);
  return element;
}

/** Zooms and moves with the usual keys: + − 0 and the arrows. */
export function zoomByKey(key: string, zoom: Zoom): boolean {
  const actions: Record<string, () => void> = {
    "+": () => zoom.zoom(STEP),
    "=": () => zoom.zoom(STEP),
    "-": () => zoom.zoom(1 / STEP),
    "0": () => zoom.all(),
    ArrowLeft: () => zoom.move(-0.2),
    ArrowRight: () => zoom.move(0.2),
  };
  actions[key]?.();
  return key in actions;
}
