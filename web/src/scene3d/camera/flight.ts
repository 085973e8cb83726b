/** The animated motion of the camera to a viewpoint; short, so that users keep their orientation. */

import type { Vector3 } from "three";
import type { Orbit } from "./useOrbitKeys";
import type { Viewing } from "./viewpoints";

const DURATION = 350; // ms

interface Flight {
  from: Viewing;
  to: Viewing;
  begun: number;
}

interface Eye {
  position: Vector3;
}

let flight: Flight | null = null;

/** Starts the motion; returns its duration [ms]. */
export function fly(from: Viewing, to: Viewing, atOnce: boolean): number {
  flight = { from, to, begun: atOnce ? -DURATION : performance.now() };
  return atOnce ? 0 : DURATION;
}

export function land(): void {
  flight = null;
}

/** Updates the camera during the motion. */
export function flyOn(eye: Eye, orbit: Orbit): void {
  if (flight === null) return;
  const share = Math.min((performance.now() - flight.begun) / DURATION, 1);
  const eased = share * share * (3 - 2 * share);
  eye.position.lerpVectors(flight.from.position, flight.to.position, eased);
  orbit.target.lerpVectors(flight.from.target, flight.to.target, eased);
  orbit.update();
  if (share === 1) flight = null;
}

/** Moves the camera and its target by a step, or to the end of the motion. */
export function shift(way: Vector3, eye: Eye, orbit: Orbit): void {
  if (way.lengthSq() === 0) return;
  const points = flight === null ? [eye.position, orbit.target] : [flight.to.position, flight.to.target];
  for (const point of points) point.add(way);
  orbit.update();
}
