import { useThree } from "@react-three/fiber";
import { type RefObject, useEffect } from "react";
import type { Group } from "three";
import { useSelection } from "../selection/selection";
import { elementAt } from "./pointing";

const STILL = 5; // px: a click that moves farther is a drag
const PAUSE = 60; // ms between two hit tests

/** Hovers and selects the element under the pointer. */
export function Pointer({ among }: { among: RefObject<Group | null> }) {
  const canvas = useThree((three) => three.gl.domElement);
  const camera = useThree((three) => three.camera);
  useEffect(() => {
    const at = (event: PointerEvent) =>
      among.current === null ? null : elementAt({ x: event.clientX, y: event.clientY }, canvas, camera, among.current);
    return listen(canvas, at);
  }, [canvas, camera, among]);
  return null;
}

function listen(canvas: HTMLElement, at: (event: PointerEvent) => string | null): () => void {
  let pressed: { x: number; y: number } | null = null;
  let timer: ReturnType<typeof setTimeout> | undefined;
  let latest: PointerEvent | undefined;
  let looked = 0; // ms
  const look = () => {
    timer = undefined;
    looked = performance.now();
    if (latest !== undefined && pressed === null) hover(at(latest), canvas);
  };
  const end = new AbortController();
  const on = (name: "pointermove" | "pointerdown" | "pointerup" | "pointerleave", then: (e: PointerEvent) => void) =>
    canvas.addEventListener(name, then, { signal: end.signal });
  on("pointermove", (event) => {
    latest = event;
    timer ??= setTimeout(look, Math.max(0, looked + PAUSE - performance.now()));
  });
  on("pointerdown", (event) => (pressed = event.button === 0 ? { x: event.clientX, y: event.clientY } : null));
  on("pointerup", (event) => {
    const still = pressed !== null && Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) < STILL;
    pressed = null;
    if (still) choose(at(event));
  });
  on("pointerleave", () => {
    latest = undefined;
    hover(null, canvas);
  });
  return () => {
    end.abort();
    clearTimeout(timer);
  };
}

function hover(id: string | null, canvas: HTMLElement): void {
  const { hovered, pick, hover } = useSelection.getState();
  if (id !== hovered) hover(id);
  const useful = id !== null && (pick === null || pick.fits(id));
  canvas.style.cursor = useful ? "pointer" : pick === null ? "" : "crosshair";
}

/** A click on nothing deselects, but does not cancel a pick. */
function choose(id: string | null): void {
  const { pick, choose } = useSelection.getState();
  if (id !== null || pick === null) choose(id);
}
