/** Undo and redo: Ctrl+Z and Ctrl+Shift+Z act on the part of the page that is shown. */

import { useEffect, useRef, useState } from "react";
import { shallow } from "zustand/shallow";
import { notifyProblem } from "./problems";

/** What can be taken back and done again; null for nothing. */
export interface History {
  undo: (() => void) | null;
  redo: (() => void) | null;
}

const shown: { current: History }[] = [];

/** Lets the keys act on a history while the component is mounted; the last one mounted counts. */
export function useHistoryKeys(history: History): void {
  const latest = useRef(history);
  useEffect(() => {
    latest.current = history;
  });
  useEffect(() => {
    shown.push(latest);
    return () => void shown.splice(shown.indexOf(latest), 1);
  }, []);
}

export function pressed(command: keyof History): void {
  shown.at(-1)?.current[command]?.();
}

/**
 * The history of a value that is replaced by each change.
 *
 * @param restore - Sets a value of the past or future.
 * @param prepare - Does what has to succeed before that.
 */
export function useHistoryOf<Value>(
  value: Value,
  restore: (value: Value) => void,
  prepare?: (value: Value) => Promise<void>,
): History {
  const [{ past, now, future }, set] = useState<Past<Value>>({ past: [], now: value, future: [] });
  if (!shallow(now, value)) set({ past: [...past, now], now: value, future: [] });
  const go = (next: Past<Value>) => {
    const done = () => {
      set(next);
      restore(next.now);
    };
    if (prepare) prepare(next.now).then(done).catch(notifyProblem);
    else done();
  };
  const [last, coming] = [past.at(-1), future.at(-1)];
  return {
    undo: last === undefined ? null : () => go({ past: past.slice(0, -1), now: last, future: [...future, now] }),
    redo: coming === undefined ? null : () => go({ past: [...past, now], now: coming, future: future.slice(0, -1) }),
  };
}

interface Past<Value> {
  past: readonly Value[];
  now: Value;
  future: readonly Value[];
}
