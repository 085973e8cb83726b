/** Access for tests and measurements to the rendered view, which is not in the DOM. */

import { type Camera, Matrix4, Vector3, type WebGLRenderer } from "three";
import { crowd } from "./elements/crowd";
import { deviceInMap } from "./frames";
import { poseOf } from "./pose";
import { onPicture, pointOf, type Spot } from "./pointing";
import { carrierOf, useModels } from "./robots/models";

export interface Hook {
  /** CSS pixels of the centre of an element in the page; null if it is not visible. */
  screen: (id: string) => Spot | null;
  /** Ids of all drawn elements. */
  shown: () => string[];
  /** Position and quaternion (x, y, z, w) in the map, as drawn now; null if it has no pose. */
  pose: (id: string) => number[] | null;
  /** Joint angles [rad], or lengths [m], by name, as drawn now. */
  joints: (robot: string) => Record<string, number>;
  /** Frames rendered since the page was opened. */
  frames: number;
  /** Duration of the last frame on the main thread [ms]. */
  drawMs: number;
  stats: () => { triangles: number; calls: number; geometries: number; textures: number };
}

declare global {
  interface Window {
    skiros3d?: Hook;
  }
}

const matrix = new Matrix4();
const point = new Vector3();

/** Adds the hook to the window; returns the function that removes it. */
export function offerHook(gl: WebGLRenderer, camera: Camera): () => void {
  const hook: Hook = {
    screen: (id) => screenOf(id, gl.domElement, camera),
    shown: () => crowd.ids(),
    pose: (id) => poseNow(id),
    joints: (robot) => Object.fromEntries(jointsOf(robot)),
    get frames() {
      return gl.info.render.frame;
    },
    drawMs: 0,
    stats: () => ({ ...numbers(gl) }),
  };
  window.skiros3d = hook;
  return () => delete window.skiros3d;
}

function numbers({ info }: WebGLRenderer) {
  const { triangles, calls } = info.render;
  return { triangles, calls, geometries: info.memory.geometries, textures: info.memory.textures };
}

function screenOf(id: string, canvas: HTMLElement, camera: Camera): Spot | null {
  const { left, top, width, height } = canvas.getBoundingClientRect();
  const spot = pointOf(id, "middle", point) ? onPicture(point, camera, width, height) : null;
  return spot === null ? null : { x: left + spot.x, y: top + spot.y };
}

function poseNow(id: string): number[] | null {
  if (!deviceInMap(carrierOf.get(id) ?? "", matrix) && !crowd.poseOf(id, matrix)) return null;
  const { position, orientation } = poseOf(matrix);
  return [...position, ...orientation];
}

function jointsOf(robot: string): [string, number][] {
  const joints = Object.entries(useModels.getState()[robot]?.joints ?? {});
  return joints.filter(([, joint]) => joint.jointType !== "fixed").map(([name, joint]) => [name, joint.angle]);
}
