/** The labels of the picture, and where in the map each of them is; they are moved once a frame. */

import type { Vector3 } from "three";

/** Writes where a label belongs; false for nowhere. */
export type Whereabouts = (into: Vector3) => boolean;

export const labelNodes = new Map<HTMLElement, Whereabouts>();

/** Keeps a label where it belongs; returns how to end that. */
export function hold(node: HTMLElement | null, where: Whereabouts): () => void {
  if (node === null) return () => undefined;
  labelNodes.set(node, where);
  return () => void labelNodes.delete(node);
}
