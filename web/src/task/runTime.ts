/** Run time that goes on over restarts of the server: it starts at zero each time. */

import type { TraceEntry } from "./trace";

/** From which moment on [s] times are later than run time was, and by how much [s]: in order, as replays tell it. */
export type Shifts = readonly (readonly [since: number, by: number])[];

const SAME = 0.1; // s: the beginning is told with the state of the cycle before

/**
 * Returns entries with times that never step back.
 *
 * @param shifts - Those of a replay: the entries get its times. Without them run time goes on without a gap.
 */
export function evened(told: readonly TraceEntry[], shifts: Shifts = []): TraceEntry[] {
  const clock = new Clock(shifts);
  return told.map((entry, index) => ({ ...entry, time: clock.read(entry, index > 0), shift: clock.shift }));
}

class Clock {
  shift = 0;
  private last = 0;
  private passed = 0;

  constructor(private readonly known: Shifts) {}

  /** Returns the time of the next entry, which may be the first one after a restart. */
  read(entry: TraceEntry, later: boolean): number {
    if (later && (this.isNext(entry) || entry.time + this.shift < this.last - SAME)) this.goOn(entry);
    // Of what a crash took from the replay nothing may come after that which follows.
    const end = this.known[this.passed]?.[0] ?? Number.POSITIVE_INFINITY;
    this.last = Math.max(this.last, Math.min(entry.time + this.shift, end));
    return this.last;
  }

  /** Whether it is the beginning of the next part of the replay. */
  private isNext({ what, time }: TraceEntry): boolean {
    const next = this.known[this.passed];
    return what === "begun" && next !== undefined && Math.abs(time - (next[0] - next[1])) < SAME;
  }

  private goOn(entry: TraceEntry): void {
    const next = this.known[this.passed];
    this.passed += 1;
    this.shift = next?.[1] ?? this.last - entry.time;
  }
}
