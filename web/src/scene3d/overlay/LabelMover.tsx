import { useFrame } from "@react-three/fiber";
import { type Camera, Vector3 } from "three";
import { onPicture } from "../pointing";
import { turnCompass } from "./compassAxes";
import { labelNodes, type Whereabouts } from "./labelNodes";

const point = new Vector3();
const LINE = 20; // px
const WIDEST = 234; // px, with its padding
const taken: { x: number; y: number; half: number }[] = [];

/** Turns the compass, and moves the labels to where their elements are drawn; those that would cover others go above them. */
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
  const half = Math.min(WIDEST, node.textContent.length * 6.5 + 14) / 2; // measured is too slow, every frame
  const x = Math.max(half, Math.min(spot.x, width - half)); // long ones stay in the picture
  const transform = `translate(${Math.round(x)}px, ${Math.round(free(x, spot.y, half))}px)`;
  if (node.style.transform !== transform) node.style.transform = transform;
}

/** The lowest line at or above a spot that no other label has. */
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
