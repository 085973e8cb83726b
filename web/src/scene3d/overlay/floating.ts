/** Labels of detections, which are not elements. */

import type { Vector3 } from "three";
import { create } from "zustand";

export interface FloatingLabel {
  key: string;
  /** A class; null if no class fits. */
  type: string | null;
  point: Vector3;
}

interface Floating {
  labels: readonly FloatingLabel[];
  show: (labels: readonly FloatingLabel[]) => void;
}

export const useFloating = create<Floating>((set) => ({ labels: [], show: (labels) => set({ labels }) }));
