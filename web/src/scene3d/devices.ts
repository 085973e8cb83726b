/** Joints and frames of the devices as drawn: interpolated between live states, or from a replay. */

import { type StationState, useStation } from "../live/station";
import { useReplay } from "./replay";
import { framesAt } from "./replayFrames";
import { wake } from "./ticker";

/** Poses of devices of any kind. */
export interface Devices {
  /** Frames in the map by device: position [m], and a quaternion x, y, z, w. */
  frames: Record<string, number[]>;
  /** Positions of joints by "robot/joint" or "device/joint" [rad or m]. */
  joints: Record<string, number[]>;
}

type Numbers = readonly number[];

const NONE: Numbers = [];
const SORTS = ["frames", "joints"] as const;
const LONGEST = 120; // ms
const SHORTEST = 30; // ms
const STILL = 2e-4; // rad or m: smaller changes are not visible

/** The state as drawn; read only. */
export const devices: Devices = nothing();

let from: Devices = nothing();
let to: Devices = nothing();
let arrived = 0; // ms
let span = SHORTEST; // ms

/** Follows the stream of states; returns the function that stops it. */
export function followDevices(): () => void {
  const { state } = useStation.getState();
  if (state !== null) begin(devicesOf(state));
  return useStation.subscribe(({ state, at }) => {
    if (state !== null) take(devicesOf(state), at);
  });
}

/** Updates the devices for a time [ms, performance.now()]. */
export function moveDevices(now: number): void {
  const { replay, piece, time } = useReplay.getState();
  if (replay !== null && piece !== null) framesAt(piece, time, devices);
  else between(from, to, Math.min((now - arrived) / span, 1), devices);
}

export function devicesOf(state: StationState): Devices {
  const found = nothing();
  for (const [id, pose] of Object.entries({ ...state.frames, ...state.platforms })) {
    found.frames[id] = [...pose.position, ...pose.orientation];
  }
  for (const [name, position] of Object.entries(state.joints)) found.joints[name] = [position];
  return found;
}

/** Writes interpolated values. */
export function between(one: Devices, other: Devices, share: number, into: Devices): void {
  for (const sort of SORTS) {
    for (const id in other[sort]) {
      const end = other[sort][id] ?? NONE;
      blend(one[sort][id] ?? end, end, share, (into[sort][id] ??= [...end]));
    }
  }
}

const POSE = 7; // numbers: position and quaternion

/** Interpolates between two sets of numbers of a device; frames rotate the short way round. */
export function blend(one: Numbers, other: Numbers, share: number, into: number[]): void {
  const turns = other.length === POSE;
  const sign = turns && dot(one, other) < 0 ? -1 : 1;
  for (let i = 0; i < other.length; i++) {
    const end = other[i] ?? 0;
    const start = (one[i] ?? end) * (turns && i > 2 ? sign : 1);
    into[i] = start + (end - start) * share;
  }
  if (turns) normalise(into);
}

/** Dot product of two orientations: below 0, they have opposite signs. */
function dot(one: Numbers, other: Numbers): number {
  return [3, 4, 5, 6].reduce((sum, i) => sum + (one[i] ?? 0) * (other[i] ?? 0), 0);
}

function normalise(pose: number[]): void {
  const length = Math.sqrt(dot(pose, pose)) || 1;
  for (let i = 3; i < POSE; i++) pose[i] = (pose[i] ?? 0) / length;
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
  return SORTS.some((sort) =>
    Object.entries(other[sort]).some(([id, numbers]) => {
      const before = one[sort][id];
      return numbers.some((value, i) => Math.abs(value - (before?.[i] ?? Number.NaN)) > STILL || before === undefined);
    }),
  );
}

function nothing(): Devices {
  return { frames: {}, joints: {} };
}
