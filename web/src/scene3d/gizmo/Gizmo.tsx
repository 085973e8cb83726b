import { TransformControls } from "@react-three/drei";
import { useEffect, useMemo } from "react";
import { Object3D } from "three";
import { useSelection } from "../../selection/selection";
import { useShowings } from "../elements/crowd";
import { useReplay } from "../replay";
import type { Palette } from "../palette";
import { wake } from "../ticker";
import { type MapPose, useTools } from "../tools";
import { Draft } from "./Draft";
import { startOf, useBodies, useElement, useObstacle } from "./useMovable";
import { TrueBodies } from "./TrueBodies";
import { snapped } from "./surfaces";
import { useCollision } from "./useCollision";

/** Handles on the selected element, which move its believed pose or its simulated body. */
export function Gizmo({ palette }: { palette: Palette }) {
  const tool = useTools((tools) => tools.tool);
  const selected = useSelection((state) => state.selected);
  const element = useElement(selected);
  const past = useReplay((state) => state.replay !== null);
  const obstacle = useObstacle(tool, element);
  if (tool === "select" || past) return null;
  return (
    <>
      {tool === "body" && <TrueBodies palette={palette} />}
      {selected !== null && element !== undefined && obstacle === null && (
        <Handles key={`${tool} ${selected}`} id={selected} palette={palette} />
      )}
    </>
  );
}

function Handles({ id, palette }: { id: string; palette: Palette }) {
  const { tool, mode, snap, draft, set } = useTools();
  const showings = useShowings();
  const bodies = useBodies();
  const proxy = useMemo(() => new Object3D(), []);
  const pose = draft?.element === id ? draft.pose : null;
  useEffect(() => {
    const at = pose ?? startOf(tool, id, bodies);
    if (at !== null) put(proxy, at);
    wake();
  }, [proxy, pose, tool, id, bodies, showings]);
  const moved = () => {
    const next = mode === "translate" ? snapped(id, taken(proxy)) : taken(proxy);
    set({ draft: { element: id, pose: next } });
  };
  const hit = useCollision(id, pose).length > 0;
  return (
    <>
      <primitive object={proxy} />
      <TransformControls
        object={proxy}
        mode={mode}
        space={mode === "rotate" ? "local" : "world"}
        size={0.8}
        translationSnap={snap.translate || null}
        rotationSnap={snap.rotate || null}
        onObjectChange={moved}
      />
      {pose !== null && (
        <Draft id={id} pose={pose} colour={hit ? palette.wrong : tool === "body" ? palette.truth : palette.selected} />
      )}
    </>
  );
}

function put(proxy: Object3D, { position, orientation }: MapPose): void {
  proxy.position.fromArray(position);
  proxy.quaternion.fromArray(orientation);
}

function taken({ position, quaternion }: Object3D): MapPose {
  const { x, y, z, w } = quaternion;
  return { position: [position.x, position.y, position.z], orientation: [x, y, z, w] };
}
