import { useThree } from "@react-three/fiber";
import { type ComponentRef, type RefObject, useEffect } from "react";
import type { OrbitControls } from "@react-three/drei";
import { wake } from "../ticker";

export type Orbit = ComponentRef<typeof OrbitControls>;

const TURN = Math.PI / 24; // rad
const NEARER = 0.88;

const TURNS: Record<string, (orbit: Orbit) => void> = {
  ArrowLeft: (orbit) => orbit.setAzimuthalAngle(orbit.getAzimuthalAngle() - TURN),
  ArrowRight: (orbit) => orbit.setAzimuthalAngle(orbit.getAzimuthalAngle() + TURN),
  ArrowUp: (orbit) => orbit.setPolarAngle(Math.max(orbit.getPolarAngle() - TURN, 0.01)),
  ArrowDown: (orbit) => orbit.setPolarAngle(orbit.getPolarAngle() + TURN),
  "+": (orbit) => come(orbit, NEARER),
  "-": (orbit) => come(orbit, 1 / NEARER),
};

/** Turns the view with the arrow keys and zooms with + and -, while the view has the focus. */
export function useOrbitKeys(controls: RefObject<Orbit | null>): void {
  const picture = useThree((three) => three.gl.domElement.closest<HTMLElement>("[data-picture]"));
  useEffect(() => {
    const turn = (event: KeyboardEvent) => {
      const how = TURNS[event.key];
      if (how === undefined || controls.current === null || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      how(controls.current);
      controls.current.update();
      wake();
    };
    picture?.addEventListener("keydown", turn);
    return () => picture?.removeEventListener("keydown", turn);
  }, [picture, controls]);
}

function come(orbit: Orbit, share: number): void {
  orbit.object.position.sub(orbit.target).multiplyScalar(share).add(orbit.target);
}
