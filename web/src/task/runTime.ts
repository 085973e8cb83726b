/** Run time made continuous over restarts of the server, at which it starts at zero. */

import type { TraceEntry } from "./trace";

/** Offsets of the replay's times from run time [s], each with the time from which it applies [s], in order. */
export type Shifts = readonly (readonly [since: number, by: number])[];

const SAME = 0.1; // s: the first entry has the time of the preceding cycle

/**
 * Returns entries with non-decreasing times.
 *
 * @param shifts - The offsets of a replay, whose times are used. Without them, run time continues without a gap.
 */
export function evened(entries: readonly TraceEntry[], shifts: Shifts = []): TraceEntry[] {
  const clock = new Clock(shifts);
  return entries.map((entry, index) => ({ ...entry, time: clock.read(entry, index > 0), shift: clock.shift }));
}

class Clock {
  shift = 0;
  private last = 0;
  private passed = 0;

  constructor(private readonly known: Shifts) {}

  /** Returns the time of the next entry, which may be the first one after a restart. */
  read(entry: TraceEntry, later: boolean): number {
    if (later && (this.isNext(entry) || entry.time + this.shift < this.last - SAME)) this.goOn(entry);
    // Entries that the replay lost in a crash must not come after later ones.
    const end = this.known[this.passed]?.[0] ?? Number.POSITIVE_INFINITY;
    this.last = Math.max(this.last, Math.min(entry.time + this.shift, end));
    return this.last;
  }

  /** Whether the next part of the replay begins. */
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
