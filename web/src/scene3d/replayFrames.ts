/** A replay at one time: joints and frames of the devices, and the visible world. */

import type { Schema } from "../api/client";
import { blend, type Devices } from "./devices";
import { merged, type View, viewFrom } from "./view";

type Replay = Schema<"Replay">;

/**
 * Writes the joints and frames of the devices at a time [s], interpolated between the two nearest frames.
 *
 * Nothing is recorded while the job is held or no server runs: the devices keep their poses, then jump.
 */
export function framesAt(replay: Replay, time: number, into: Devices): void {
  const { times, joints, frames } = replay.frames;
  const after = Math.min(firstAfter(times, time), times.length - 1);
  const before = Math.max(after - 1, 0);
  const [start, end] = [times[before] ?? 0, times[after] ?? 0];
  const gap = gapWithin(gapsOf(replay), start, end);
  const share = gap === undefined ? shareOf(start, end, time) : Number(time >= gap);
  for (const [id, track] of Object.entries(joints)) at("joints", id, [track[before] ?? 0], [track[after] ?? 0]);
  for (const [id, track] of Object.entries(frames)) at("frames", id, track[before], track[after]);

  function at(sort: keyof Devices, id: string, start: readonly number[] = [], end: readonly number[] = []): void {
    blend(start, end, share, (into[sort][id] ??= [...end]));
  }
}

const ROUNDED = 1e-4; // s: times of frames are rounded, times of changes are not
const gaps = new WeakMap<Replay, readonly number[]>();

/** Times at which the job was continued after it was held or interrupted [s]. */
function gapsOf(replay: Replay): readonly number[] {
  const known = gaps.get(replay);
  if (known !== undefined) return known;
  const found = replay.changes.filter(({ whole }) => whole).map((change) => change.time - ROUNDED);
  gaps.set(replay, found);
  return found;
}

function gapWithin(ends: readonly number[], start: number, end: number): number | undefined {
  return ends.find((one) => start < one && one <= end);
}

function shareOf(start: number, end: number, time: number): number {
  return end > start ? Math.min(Math.max((time - start) / (end - start), 0), 1) : 1;
}

/** Index of the first element of a sorted array that is greater than a number. */
export function firstAfter(ascending: readonly number[], value: number): number {
  let [low, high] = [0, ascending.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((ascending[middle] ?? 0) > value) high = middle;
    else low = middle + 1;
  }
  return low;
}

/** The view after a change; a complete view replaces the previous one. */
function changed(view: View, { whole, view: next }: Replay["changes"][number]): View {
  if (!whole) return merged(view, next);
  return { ...viewFrom(next), shapes: { ...view.shapes, ...next.shapes } };
}

/** Returns the view at a time; moving forward is fast, moving back starts at the beginning. */
export class PastViews {
  private view: View;
  private done = 0;
  private readonly times: readonly number[];

  constructor(private readonly replay: Replay) {
    this.view = viewFrom(replay.beginning);
    this.times = replay.changes.map((change) => change.time);
  }

  at(time: number): View {
    const wanted = firstAfter(this.times, time);
    if (wanted < this.done) this.restart();
    for (const change of this.replay.changes.slice(this.done, wanted)) this.view = changed(this.view, change);
    this.done = wanted;
    return this.view;
  }

  private restart(): void {
    this.view = { ...viewFrom(this.replay.beginning), shapes: this.view.shapes };
    this.done = 0;
  }
}
