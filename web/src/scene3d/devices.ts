/** Where the robots' devices are in the frame that is drawn: between two states of the present, or in a replay. */

import type { Schema } from "../api/client";
import { type StationState, useStation } from "../live/station";
import { headingOf } from "./pose";
import { useReplay } from "./replay";
import { framesAt } from "./replayFrames";
import { wake } from "./ticker";

/** Numbers of all devices by their ids. */
export interface Devices {
  /** Joint angles [rad]. */
  arms: Record<string, number[]>;
  /** Distance between the fingers [m]. */
  grippers: Record<string, number[]>;
  /** x [m], y [m], heading [rad] in the map. */
  bases: Record<string, number[]>;
}

type Numbers = readonly number[];

const NONE: Numbers = [];
const KINDS = ["arms", "grippers", "bases"] as const;
const LONGEST = 120; // ms
const SHORTEST = 30; // ms
const STILL = 2e-4; // rad or m: less is not visible

/** As they are drawn now; read only. */
export const devices: Devices = nothing();

let from: Devices = nothing();
let to: Devices = nothing();
let arrived = 0; // ms
let span = SHORTEST; // ms

/** Follows the stream of states; returns how to end that. */
export function followDevices(): () => void {
  const { state } = useStation.getState();
  if (state !== null) begin(devicesOf(state));
  return useStation.subscribe(({ state, at }) => {
    if (state !== null) take(devicesOf(state), at);
  });
}

/** Brings the devices to where they are at a moment [ms, performance.now()]. */
export function moveDevices(now: number): void {
  const { replay, piece, time } = useReplay.getState();
  if (replay !== null && piece !== null) framesAt(piece, time, devices);
  else between(from, to, Math.min((now - arrived) / span, 1), devices);
}

export function devicesOf(state: StationState): Devices {
  const found = nothing();
  for (const [id, arm] of Object.entries(state.arms)) found.arms[id] = arm.positions;
  for (const [id, gripper] of Object.entries(state.grippers)) found.grippers[id] = [gripper.gap];
  for (const [id, base] of Object.entries(state.bases)) found.bases[id] = planar(base.pose);
  return found;
}

/** Writes what is a share of the way from one to the other; headings go the short way round. */
export function between(one: Devices, other: Devices, share: number, into: Devices): void {
  for (const kind of KINDS) {
    for (const id in other[kind]) {
      const end = other[kind][id] ?? NONE;
      blend(kind, one[kind][id] ?? end, end, share, (into[kind][id] ??= [...end]));
    }
  }
}

/** Writes what is a share of the way from some numbers of a device to others. */
export function blend(kind: keyof Devices, one: Numbers, other: Numbers, share: number, into: number[]): void {
  for (let i = 0; i < other.length; i++) {
    const end = other[i] ?? 0;
    const start = one[i] ?? end;
    into[i] = start + way(kind, i, start, end) * share;
  }
}

/** How far it is from one number to the other. */
function way(kind: keyof Devices, index: number, start: number, end: number): number {
  if (kind !== "bases" || index !== 2) return end - start;
  return Math.atan2(Math.sin(end - start), Math.cos(end - start));
}

function take(next: Devices, at: number): void {
  if (arrived === 0) return begin(next);
  const now = nothing();
  between(from, to, Math.min((performance.now() - arrived) / span, 1), now);
  const moves = differ(now, next);
  [from, to] = [now, next];
  span = Math.min(Math.max(at - arrived, SHORTEST), LONGEST);
  arrived = at;
  if (moves && useReplay.getState().replay === null) wake(span);
}

function begin(first: Devices): void {
  from = to = first;
  arrived = performance.now();
  wake();
}

function differ(one: Devices, other: Devices): boolean {
  return KINDS.some((kind) =>
    Object.entries(other[kind]).some(([id, numbers]) => {
      const before = one[kind][id];
      return numbers.some((value, i) => Math.abs(value - (before?.[i] ?? Number.NaN)) > STILL || before === undefined);
    }),
  );
}

function nothing(): Devices {
  return { arms: {}, grippers: {}, bases: {} };
}

function planar(pose: Schema<"PoseInfo">): number[] {
  return [pose.position[0], pose.position[1], headingOf(pose)];
}
