/** Numbers of the robots' state, twenty times a second, without rendering again. */

import { type RefObject, useEffect, useRef, useState } from "react";
import { type StationState, useStation } from "../../live/station";

/** Calls a function with each state, to write a number straight into an element of the page. */
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
const SMALL = 0.0015; // rad: a standing joint trembles by less

/** Returns the joint angles of an arm as it stood last; they stay the same while it moves. */
export function useRest(arm: string): readonly number[] {
  const [rest, setRest] = useState(NOTHING);
  useEffect(() => {
    const look = ({ state }: { state: StationState | null }) => {
      const now = state?.arms[arm];
      if (now?.still) setRest((before) => (differs(before, now.positions) ? now.positions : before));
    };
    look(useStation.getState());
    return useStation.subscribe(look);
  }, [arm]);
  return rest;
}

function differs(before: readonly number[], now: readonly number[]): boolean {
  return before.length !== now.length || now.some((angle, joint) => Math.abs(angle - (before[joint] ?? 0)) > SMALL);
}
