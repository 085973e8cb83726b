/** Live numbers of the robots' state, 20 times a second, without rendering. */

import { type RefObject, useEffect, useRef, useState } from "react";
import { type StationState, useStation } from "../../live/station";

/** Calls a function with each state, to write numbers directly into DOM elements. */
export function useLive<E extends HTMLElement>(show: (element: E, state: StationState) => void): RefObject<E | null> {
  const element = useRef<E>(null);
  const latest = useRef(show);
  useEffect(() => {
    latest.current = show;
  });
  useEffect(() => {
    const write = ({ state }: { state: StationState | null }) => {
      if (element.current !== null && state !== null) latest.current(element.current, state);
    };
    write(useStation.getState());
    return useStation.subscribe(write);
  }, []);
  return element;
}

const NOTHING: readonly number[] = [];
const SMALL = 0.0015; // rad: the noise of a joint at rest

/** Returns the last positions at rest of joints ("robot/joint"); unchanged while they move. */
export function useRest(names: readonly string[]): readonly number[] {
  const [rest, setRest] = useState(NOTHING);
  const key = names.join(" ");
  useEffect(() => {
    let last = NOTHING;
    const look = ({ state }: { state: StationState | null }) => {
      if (state === null) return;
      const now = key.split(" ").map((name) => state.joints[name] ?? 0);
      if (!differs(last, now)) setRest((before) => (differs(before, now) ? now : before));
      last = now;
    };
    look(useStation.getState());
    return useStation.subscribe(look);
  }, [key]);
  return rest;
}

function differs(before: readonly number[], now: readonly number[]): boolean {
  return before.length !== now.length || now.some((angle, joint) => Math.abs(angle - (before[joint] ?? 0)) > SMALL);
}
