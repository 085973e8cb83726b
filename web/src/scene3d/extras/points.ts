/** Point clouds of cameras in the API's format. */

import { Color, SRGBColorSpace } from "three";
import type { Schema } from "../../api/client";

export interface Cloud {
  /** x, y, z [m] of each point. */
  places: Float32Array;
  /** Red, green, blue of each point, linear from 0 to 1; null without colours. */
  colours: Float32Array | null;
}

/** Linear brightness of a byte of an image. */
const LINEAR = Float32Array.from({ length: 256 }, (_, i) => new Color().setRGB(i / 255, 0, 0, SRGBColorSpace).r);

export function cloudOf(observation: Schema<"Observation">): Cloud {
  const places = new Float32Array(bytesOf(observation.points).buffer);
  const bytes = bytesOf(observation.colours);
  if (bytes.length !== places.length) return { places, colours: null };
  return { places, colours: Float32Array.from(bytes, (byte) => LINEAR[byte] ?? 0) };
}

/** The cloud thinned to a number of points: every second point, every third, …. */
export function thinned({ places, colours }: Cloud, most: number): Cloud {
  const step = Math.ceil(places.length / 3 / most);
  if (step <= 1) return { places, colours };
  const kept = (_: number, i: number) => Math.floor(i / 3) % step === 0;
  return { places: places.filter(kept), colours: colours?.filter(kept) ?? null };
}

function bytesOf(text: string): Uint8Array<ArrayBuffer> {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}
