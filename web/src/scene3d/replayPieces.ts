/** Loads a replay in pieces: the current one and the next one, never the whole of a long job. */

import type { Schema } from "../api/client";

/** The part of a replay in a time range; it begins with the world at that time. */
export type Piece = Schema<"Replay">;

/** Fetches the piece between two run times [s]. */
export type Read = (start: number, end: number) => Promise<Piece>;

export const LENGTH = 60; // s of run time
const MOST = 30; // pieces kept in memory
const AGAIN = 1000; // ms, after a failed request

/** The pieces of one replay. */
export class Pieces {
  private readonly known = new Map<number, Piece>();
  private wanted: readonly number[] = [];
  private busy = false;

  constructor(
    private readonly replay: Piece,
    private readonly read: Read,
    private readonly onRead: () => void,
  ) {}

  /** Returns the piece at a time [s], undefined while it is being fetched; requests it and the next one. */
  at(time: number): Piece | undefined {
    const last = this.numberOf(this.replay.end);
    const number = Math.min(this.numberOf(time), last);
    this.wanted = number < last ? [number, number + 1] : [number];
    void this.readMissing();
    return this.known.get(number);
  }

  /** Stops fetching. */
  close(): void {
    this.wanted = [];
  }

  private numberOf(time: number): number {
    return Math.max(Math.floor((time - this.replay.start) / LENGTH), 0);
  }

  /** Fetches one piece at a time, so that only pieces at the current position of a fast slider are requested. */
  private async readMissing(): Promise<void> {
    if (this.busy) return;
    this.busy = true;
    for (let next = this.missing(); next !== undefined; next = this.missing()) {
      const start = this.replay.start + next * LENGTH;
      try {
        this.keep(next, await this.read(start, start + LENGTH));
      } catch {
        await new Promise((resume) => setTimeout(resume, AGAIN));
      }
    }
    this.busy = false;
  }

  private missing(): number | undefined {
    return this.wanted.find((number) => !this.known.has(number));
  }

  private keep(number: number, piece: Piece): void {
    this.known.set(number, piece);
    const [oldest] = this.known.keys();
    if (this.known.size > MOST && oldest !== undefined) this.known.delete(oldest);
    this.onRead();
  }
}
