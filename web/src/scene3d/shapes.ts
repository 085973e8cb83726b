/** Shapes as geometries: all boxes and cylinders of a shape merged into one, created once for each key. */

import {
  Box3,
  BoxGeometry,
  BufferAttribute,
  type BufferGeometry,
  CylinderGeometry,
  EdgesGeometry,
  Vector3,
} from "three";
import { mergeGeometries } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import { matrixOf } from "./pose";
import type { Block, View, ViewElement } from "./view";

export interface Shape {
  geometry: BufferGeometry;
  /** The bounding box, used for large batches in software rendering. */
  coarse: BufferGeometry;
  edges: EdgesGeometry;
  bounds: Box3;
}

const ROUND = 14; // segments of a cylinder
const EDGE = 25; // degrees: flatter edges are not drawn
/** Later blocks of a shape are a little darker, so that its structure is visible. */
const SHADES = [1, 0.82, 0.68, 0.9, 0.75];
/** Elements with a place but without a shape are drawn as a flat mark. */
const MARK: Block[] = [
  { kind: "cylinder", size: [0.05, 0.004], pose: { position: [0, 0, 0.002], orientation: [0, 0, 0, 1] } },
];

let known = new Map<string, { blocks: readonly Block[]; shape: Shape }>();

/** The shape of a key; "" is the mark for elements without a shape. */
export function shapeOf(key: string, blocks: readonly Block[] = MARK): Shape {
  const kept = known.get(key);
  if (kept !== undefined && same(kept.blocks, blocks)) return kept.shape;
  if (kept !== undefined) dispose(kept.shape); // keys have another meaning after a restart of the server
  const shape = built(blocks);
  known.set(key, { blocks, shape });
  return shape;
}

/** The shape of an element; null for elements that are not drawn as such: robots and their parts. */
export function shapeIn(shapes: View["shapes"], { kind, shape }: ViewElement): Shape | null {
  if (kind === "robot" || (kind === "device" && shape === null)) return null;
  return shape === null ? shapeOf("") : shapeOf(shape, shapes[shape]);
}

/** Releases all shapes. */
export function forgetShapes(): void {
  for (const { shape } of known.values()) dispose(shape);
  known = new Map();
}

/** The bounding box of some blocks, in the frame of their shape. */
export function boundsOf(blocks: readonly Block[]): Box3 {
  const shape = built(blocks);
  dispose(shape);
  return shape.bounds;
}

function same(one: readonly Block[], other: readonly Block[]): boolean {
  return one === other || JSON.stringify(one) === JSON.stringify(other);
}

function built(blocks: readonly Block[]): Shape {
  const pieces = blocks.map((block, i) => tinted(geometryOf(block), SHADES[i % SHADES.length] ?? 1));
  const geometry = mergeGeometries(pieces);
  for (const piece of pieces) piece.dispose();
  geometry.computeBoundingBox();
  const bounds = geometry.boundingBox ?? new Box3();
  return { geometry, coarse: boxAround(bounds), edges: new EdgesGeometry(geometry, EDGE), bounds };
}

function boxAround(bounds: Box3): BufferGeometry {
  const [size, middle] = [bounds.getSize(new Vector3()), bounds.getCenter(new Vector3())];
  return tinted(new BoxGeometry(size.x, size.y, size.z).translate(middle.x, middle.y, middle.z), SHADES[0] ?? 1);
}

function geometryOf({ kind, size, pose }: Block): BufferGeometry {
  const [a = 0.01, b = 0.01, c = 0.01] = size;
  const geometry =
    kind === "box" ? new BoxGeometry(a, b, c) : new CylinderGeometry(a, a, b, ROUND).rotateX(Math.PI / 2);
  geometry.deleteAttribute("uv");
  return geometry.applyMatrix4(matrixOf(pose));
}

function tinted(geometry: BufferGeometry, shade: number): BufferGeometry {
  const count = geometry.getAttribute("position").count;
  return geometry.setAttribute("color", new BufferAttribute(new Float32Array(count * 3).fill(shade), 3));
}

function dispose({ geometry, coarse, edges }: Shape): void {
  geometry.dispose();
  coarse.dispose();
  edges.dispose();
}
