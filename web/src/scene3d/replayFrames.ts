/** A replay at one moment: where the devices were, and what there was to be seen. */

import type { Schema } from "../api/client";
import { blend, type Devices } from "./devices";
import { movedBy } from "./robots/models";
import { merged, type View, viewFrom } from "./view";

type Replay = Schema<"Replay">;

/**
 * Writes where the devices were at a moment [s]: on the straight way between the two frames around it.
 *
 * While the job was held, or no server ran, their way is unknown: they stay where they were, then jump.
 */
export function framesAt(replay: Replay, time: number, into: Devices): void {
  const { times, arms, bases, grippers, devices = {} } = replay.frames;
  const after = Math.min(firstAfter(times, time), times.length - 1);
  const before = Math.max(after - 1, 0);
  const [start, end] = [times[before] ?? 0, times[after] ?? 0];
  const gap = gapWithin(gapsOf(replay), start, end);
  const share = gap === undefined ? shareOf(start, end, time) : Number(time >= gap);
  for (const [id, track] of Object.entries(arms)) moved(id, track[before], track[after]);
  for (const [id, track] of Object.entries(grippers)) moved(id, [track[before] ?? 0], [track[after] ?? 0]);
  for (const [id, track] of Object.entries(bases)) at("frames", id, upright(track[before]), upright(track[after]));
  for (const [id, { poses }] of Object.entries(devices)) {
    if (poses !== null) at("frames", id, poses[before], poses[after]);
  }

  function at(sort: keyof Devices, id: string, start: readonly number[] = [], end: readonly number[] = []): void {
    blend(start, end, share, (into[sort][id] ??= [...end]));
  }

  function moved(device: string, start: readonly number[] = [], end: readonly number[] = []): void {
    movedBy.get(device)?.forEach(({ joints, share }, i) => {
      for (const joint of joints) at("joints", joint, [(start[i] ?? 0) * share], [(end[i] ?? 0) * share]);
    });
  }
}

/** The frame of what stands upright on the floor, of x, y [m] and heading [rad]. */
function upright([x = 0, y = 0, heading = 0]: readonly number[] = []): number[] {
  return [x, y, 0, 0, 0, Math.sin(heading / 2), Math.cos(heading / 2)];
}

const ROUNDED = 1e-4; // s: times of frames are rounded, those of changes are not
const gaps = new WeakMap<Replay, readonly number[]>();

/** When a job went on that was held or cut off [s]. */
function gapsOf(replay: Replay): readonly number[] {
  const known = gaps.get(replay);
  if (known !== undefined) return known;
  const found = replay.changes.filter(({ anew }) => anew).map((change) => change.time - ROUNDED);
  gaps.set(replay, found);
  return found;
}

function gapWithin(ends: readonly number[], start: number, end: number): number | undefined {
  return ends.find((one) => start < one && one <= end);
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

/** The view after a change; one of the whole world replaces what was there. */
function changed(view: View, { anew, view: told }: Replay["changes"][number]): View {
  if (!anew) return merged(view, told);
  return { ...viewFrom(told), shapes: { ...view.shapes, ...told.shapes } };
}

/** Returns the view at a moment; going forward is quick, going back starts at the beginning. */
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
    if (wanted < this.done) this.beginAnew();
    for (const change of this.replay.changes.slice(this.done, wanted)) this.view = changed(this.view, change);
    this.done = wanted;
    return this.view;
  }

  private beginAnew(): void {
    this.view = { ...viewFrom(this.replay.beginning), shapes: this.view.shapes };
    this.done = 0;
  }
}
