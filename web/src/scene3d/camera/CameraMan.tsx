import { OrbitControls } from "@react-three/drei";
import { useFrame, useThree } from "@react-three/fiber";
import { type RefObject, useEffect, useRef } from "react";
import { PerspectiveCamera, Vector3 } from "three";
import { useSelection } from "../../selection/selection";
import { pointOf } from "../pointing";
import { carrierOf } from "../robots/models";
import { wake } from "../ticker";
import { useShownView } from "../useShownView";
import { useCamera, type Viewpoint } from "./camera";
import { fly, flyOn, land, shift } from "./flight";
import { type Orbit, useOrbitKeys } from "./useOrbitKeys";
import { viewing } from "./viewpoints";

/** Moves the camera: by pointer and keys, to a viewpoint, or with a robot. */
export function CameraMan() {
  const controls = useRef<Orbit>(null);
  useFlights(controls);
  useOrbitKeys(controls);
  useFollowing(controls);
  useFrame(({ camera }) => {
    if (controls.current !== null) flyOn(camera, controls.current);
  }, -4);
  return <OrbitControls ref={controls} makeDefault enableDamping={false} maxPolarAngle={1.55} onStart={land} />;
}

function useFlights(controls: RefObject<Orbit | null>): void {
  const camera = useThree((three) => three.camera);
  const requests = useCamera((state) => state.requests);
  const ready = useShownView() !== null;
  useEffect(() => {
    const { viewpoint } = useCamera.getState();
    if (!ready || controls.current === null || !(camera instanceof PerspectiveCamera)) return;
    const to = viewing(viewpoint, camera, focusOf(viewpoint));
    if (to === null) return;
    const from = { position: camera.position.clone(), target: controls.current.target.clone() };
    wake(fly(from, to, requests === 0 || calm())); // the first view is not animated
  }, [ready, requests, camera, controls]);
}

/** The subject of a viewpoint: a robot to follow, or the selected element. */
function focusOf(viewpoint: Viewpoint): string | null {
  const { selected } = useSelection.getState();
  if (viewpoint === "selection") return selected;
  if (selected !== null && carrierOf.has(selected)) return selected;
  return carrierOf.keys().next().value ?? null;
}

function calm(): boolean {
  return matchMedia("(prefers-reduced-motion: reduce)").matches;
}

const here = new Vector3();
const step = new Vector3();

/** Follows a robot while requested, in any viewing direction. */
function useFollowing(controls: RefObject<Orbit | null>): void {
  const following = useCamera((state) => state.viewpoint === "follow");
  const before = useRef<Vector3 | null>(null);
  useEffect(() => void (before.current = null), [following]);
  useFrame(({ camera }) => {
    const robot = following ? focusOf("follow") : null;
    if (robot === null || controls.current === null || !pointOf(robot, "middle", here)) return;
    if (before.current !== null) shift(step.subVectors(here, before.current), camera, controls.current);
    before.current = (before.current ?? new Vector3()).copy(here);
  }, -1);
}
