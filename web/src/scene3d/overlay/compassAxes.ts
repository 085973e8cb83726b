/** Turns the compass with the camera, once a frame and without React. */

import { type RefObject, useEffect } from "react";
import { type Camera, Matrix4 } from "three";

const LONG = 20; // px
const TEXT = 27; // px
const COLUMN = { x: 0, y: 4, z: 8 };

let compass: SVGSVGElement | null = null;
const last = new Matrix4();

export function useCompass(picture: RefObject<SVGSVGElement | null>): void {
  useEffect(() => {
    compass = picture.current;
    last.identity();
    return () => void (compass = null);
  }, [picture]);
}

export function turnCompass({ matrixWorldInverse }: Camera): void {
  if (compass === null || last.equals(matrixWorldInverse)) return;
  last.copy(matrixWorldInverse);
  for (const [axis, column] of Object.entries(COLUMN)) {
    const [x = 0, y = 0] = [last.elements[column], last.elements[column + 1]];
    const group = compass.querySelector(`[data-axis=${axis}]`);
    set(group?.querySelector("line"), { x2: x * LONG, y2: -y * LONG });
    set(group?.querySelector("text"), { x: x * TEXT, y: -y * TEXT });
  }
}

function set(element: Element | null | undefined, values: Record<string, number>): void {
  for (const [name, value] of Object.entries(values)) element?.setAttribute(name, value.toFixed(1));
}
