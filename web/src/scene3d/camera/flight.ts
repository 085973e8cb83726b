/** The camera's way to a viewpoint: a short one, so that people see where they go. */

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

/** Begins a flight; returns how long it takes [ms]. */
export function fly(from: Viewing, to: Viewing, atOnce: boolean): number {
  flight = { from, to, begun: atOnce ? -DURATION : performance.now() };
  return atOnce ? 0 : DURATION;
}

export function land(): void {
  flight = null;
}

/** Brings the camera to where it is on its way by now. */
export function flyOn(eye: Eye, orbit: Orbit): void {
  if (flight === null) return;
  const share = Math.min((performance.now() - flight.begun) / DURATION, 1);
  const eased = share * share * (3 - 2 * share);
  eye.position.lerpVectors(flight.from.position, flight.to.position, eased);
  orbit.target.lerpVectors(flight.from.target, flight.to.target, eased);
  orbit.update();
  if (share === 1) flight = null;
}

/** Goes by a step, or where the flight goes to. */
export function shift(way: Vector3, eye: Eye, orbit: Orbit): void {
  if (way.lengthSq() === 0) return;
  const points = flight === null ? [eye.position, orbit.target] : [flight.to.position, flight.to.target];
  for (const point of points) point.add(way);
  orbit.update();
}
