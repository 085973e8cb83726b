/** Draws when there is something new to be seen, and no more often than is of use. */

import { quality } from "./quality";

const SOON = 8; // ms: what a click changes comes in several pieces, and a frame is dear

let draw: (() => void) | null = null;
let until = 0; // ms
let last = 0; // ms
let timer: ReturnType<typeof setTimeout> | undefined;

/** Says how a frame is drawn; null when the view is gone. */
export function drawBy(how: (() => void) | null): void {
  draw = how;
  if (how === null) clearTimeout(timer);
  timer = undefined;
  if (how !== null) wake();
}

/** Asks for a frame soon, and for more as long as something moves [ms]. */
export function wake(duration = 0): void {
  until = Math.max(until, performance.now() + duration);
  if (draw !== null) timer ??= setTimeout(tick, Math.max(SOON, last + pause() - performance.now()));
}

function tick(): void {
  const now = performance.now();
  const due = last + pause();
  last = now - due < pause() ? due : now; // a late frame must not delay those after it
  timer = now < until ? setTimeout(tick, Math.max(0, last + pause() - now)) : undefined;
  draw?.();
}

function pause(): number {
  return 1000 / quality().rate;
}
