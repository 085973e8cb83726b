import { OrbitControls } from "@react-three/drei";
import { useFrame, useThree } from "@react-three/fiber";
import { useCallback, useEffect, useRef } from "react";
import { PerspectiveCamera, Vector3 } from "three";
import { useSelection } from "../../selection/selection";
import { crowd } from "../elements/crowd";
import { wake } from "../ticker";
import { useShownView } from "../useShownView";
import { pointOf } from "../pointing";
import { baseOf } from "../robots/models";
import { useCamera } from "./camera";
import { type Orbit, useOrbitKeys } from "./useOrbitKeys";
import { type Viewing, viewing } from "./viewpoints";

const FLIGHT = 350; // ms

interface Flight {
  from: Viewing;
  to: Viewing;
  begun: number;
}

/** Moves the camera: by mouse and keys, to a viewpoint, with a robot. */
export function CameraMan() {
  const controls = useRef<Orbit>(null);
  const flight = useFlights(controls);
  useOrbitKeys(controls);
  useFollowing(controls, flight);
  useFrame(({ camera }) => {
    if (flight.current !== null && controls.current !== null)
      flight.current = fly(flight.current, camera, controls.current);
  }, -4);
  const stop = useCallback(() => void (flight.current = null), []);
  return <OrbitControls ref={controls} makeDefault enableDamping={false} maxPolarAngle={1.55} onStart={stop} />;
}

type Ref<Value> = React.RefObject<Value>;

function useFlights(controls: Ref<Orbit | null>): Ref<Flight | null> {
  const flight = useRef<Flight | null>(null);
  const camera = useThree((three) => three.camera);
  const wishes = useCamera((state) => state.wishes);
  const ready = useShownView() !== null;
  useEffect(() => {
    const { viewpoint } = useCamera.getState();
    if (!ready || controls.current === null || !(camera instanceof PerspectiveCamera)) return;
    const to = viewing(viewpoint, camera, focusOf(viewpoint));
    if (to === null) return;
    const from = { position: camera.position.clone(), target: controls.current.target.clone() };
    const begun = wishes === 0 || calm() ? -FLIGHT : performance.now(); // there is no flight to begin with
    flight.current = { from, to, begun };
    wake(FLIGHT);
  }, [ready, wishes, camera, controls]);
  return flight;
}

/** Which element a viewpoint is about: a robot to follow, or what is selected. */
function focusOf(viewpoint: string): string | null {
  const { selected } = useSelection.getState();
  if (viewpoint === "selection") return selected;
  if (selected !== null && baseOf.has(selected)) return selected;
  return baseOf.keys().next().value ?? null;
}

function calm(): boolean {
  return matchMedia("(prefers-reduced-motion: reduce)").matches;
}

function fly({ from, to, begun }: Flight, camera: { position: Vector3 }, controls: Orbit): Flight | null {
  const share = Math.min((performance.now() - begun) / FLIGHT, 1);
  const eased = share * share * (3 - 2 * share);
  camera.position.lerpVectors(from.position, to.position, eased);
  controls.target.lerpVectors(from.target, to.target, eased);
  controls.update();
  return share < 1 ? { from, to, begun } : null;
}

const here = new Vector3();
const step = new Vector3();

/** Goes with a robot while that is wished, in whatever direction people look. */
function useFollowing(controls: Ref<Orbit | null>, flight: Ref<Flight | null>) {
  const following = useCamera((state) => state.viewpoint === "follow");
  const before = useRef<Vector3 | null>(null);
  useEffect(() => void (before.current = null), [following]);
  useFrame(({ camera }) => {
    const robot = following ? focusOf("follow") : null;
    if (robot === null || controls.current === null || crowd.item(robot) === undefined) return;
    if (!pointOf(robot, "middle", here)) return;
    if (before.current !== null)
      follow(step.subVectors(here, before.current), camera, controls.current, flight.current);
    before.current = (before.current ?? new Vector3()).copy(here);
  }, -1);
}

function follow(way: Vector3, camera: { position: Vector3 }, controls: Orbit, flight: Flight | null): void {
  if (way.lengthSq() === 0) return;
  for (const point of flight === null ? [camera.position, controls.target] : [flight.to.position, flight.to.target]) {
    point.add(way);
  }
  controls.update();
}
