/** Renders frames on demand, at a limited rate. */

import { quality } from "./quality";

const SOON = 8; // ms: a click causes several changes, and a frame is expensive

let draw: (() => void) | null = null;
let until = 0; // ms
let last = 0; // ms
let timer: ReturnType<typeof setTimeout> | undefined;

/** Sets the function that renders a frame; null when the view is closed. */
export function drawBy(how: (() => void) | null): void {
  draw = how;
  if (how === null) clearTimeout(timer);
  timer = undefined;
  if (how !== null) wake();
}

/** Requests a frame soon, and further ones for a duration [ms]. */
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
