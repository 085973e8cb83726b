/** The labels of the view and their positions in the map; moved once a frame. */

import type { Vector3 } from "three";

/** Writes the position of a label; false if there is none. */
export type Whereabouts = (into: Vector3) => boolean;

export const labelNodes = new Map<HTMLElement, Whereabouts>();

/** Keeps a label at a position; returns the function that stops it. */
export function hold(node: HTMLElement | null, where: Whereabouts): () => void {
  if (node === null) return () => undefined;
  labelNodes.set(node, where);
  return () => void labelNodes.delete(node);
}
