/** A replay at one moment: where the devices were, and what there was to be seen. */

import type { Schema } from "../api/client";
import { blend, type Devices } from "./devices";
import { merged, type View, viewFrom } from "./view";

type Frames = Schema<"ReplayFrames">;

/** Writes where the devices were at a moment [s]: on the straight way between the two frames around it. */
export function framesAt({ times, arms, bases, grippers }: Frames, time: number, into: Devices): void {
  const after = Math.min(firstAfter(times, time), times.length - 1);
  const before = Math.max(after - 1, 0);
  const share = shareOf(times[before] ?? 0, times[after] ?? 0, time);
  for (const [id, track] of Object.entries(arms)) at("arms", id, track[before], track[after]);
  for (const [id, track] of Object.entries(bases)) at("bases", id, track[before], track[after]);
  for (const [id, track] of Object.entries(grippers)) at("grippers", id, [track[before] ?? 0], [track[after] ?? 0]);

  function at(kind: keyof Devices, id: string, start: readonly number[] = [], end: readonly number[] = []): void {
    blend(kind, start, end, share, (into[kind][id] ??= [...end]));
  }
}

function shareOf(start: number, end: number, time: number): number {
  return end > start ? Math.min(Math.max((time - start) / (end - start), 0), 1) : 1;
}

/** Index of the first of ascending numbers that is greater than one. */
export function firstAfter(ascending: readonly number[], value: number): number {
  let [low, high] = [0, ascending.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((ascending[middle] ?? 0) > value) high = middle;
    else low = middle + 1;
  }
  return low;
}

/** Tells what was to be seen at a moment; going on is quick, going back begins anew. */
export class PastViews {
  private view: View;
  private done = 0;
  private readonly times: readonly number[];

  constructor(private readonly replay: Schema<"Replay">) {
    this.view = viewFrom(replay.beginning);
    this.times = replay.changes.map((change) => change.time);
  }

  at(time: number): View {
    const wanted = firstAfter(this.times, time);
    if (wanted < this.done) this.beginAnew();
    for (const change of this.replay.changes.slice(this.done, wanted)) this.view = merged(this.view, change.view);
    this.done = wanted;
    return this.view;
  }

  private beginAnew(): void {
    this.view = { ...viewFrom(this.replay.beginning), shapes: this.view.shapes };
    this.done = 0;
  }
}
