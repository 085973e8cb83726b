import { useFrame } from "@react-three/fiber";
import { type Camera, Vector3 } from "three";
import { onPicture } from "../pointing";
import { turnCompass } from "./compassAxes";
import { labelNodes, type Whereabouts } from "./labelNodes";

const point = new Vector3();
const LINE = 20; // px
const WIDEST = 234; // px, including padding
const taken: { x: number; y: number; half: number }[] = [];

/** Turns the compass, and moves labels to their elements; overlapping labels are moved up. */
export function LabelMover() {
  useFrame(({ camera, size }) => {
    turnCompass(camera);
    taken.length = 0;
    for (const [node, where] of labelNodes) move(node, where, camera, size);
  });
  return null;
}

function move(
  node: HTMLElement,
  where: Whereabouts,
  camera: Camera,
  { width, height }: { width: number; height: number },
) {
  const spot = where(point) ? onPicture(point, camera, width, height) : null;
  const there = spot !== null && spot.x > 0 && spot.x < width && spot.y > 0 && spot.y < height;
  const visibility = there ? "visible" : "hidden";
  if (node.style.visibility !== visibility) node.style.visibility = visibility;
  if (!there) return;
  const half = Math.min(WIDEST, node.textContent.length * 6.5 + 14) / 2; // measuring is too slow for every frame
  const x = Math.max(half, Math.min(spot.x, width - half)); // long labels stay within the view
  const transform = `translate(${Math.round(x)}px, ${Math.round(free(x, spot.y, half))}px)`;
  if (node.style.transform !== transform) node.style.transform = transform;
}

/** The lowest free line at or above a position. */
function free(x: number, y: number, half: number): number {
  let line = y;
  for (let tries = 0; tries < 2 * taken.length && taken.some((one) => covers(one, x, line, half)); tries++)
    line -= LINE;
  taken.push({ x, y: line, half });
  return line;
}

function covers(one: { x: number; y: number; half: number }, x: number, y: number, half: number): boolean {
  return Math.abs(one.x - x) < one.half + half && Math.abs(one.y - y) < LINE;
}
