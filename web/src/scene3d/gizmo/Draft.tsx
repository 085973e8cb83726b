import { useMemo } from "react";
import type { Color } from "three";
import { crowd } from "../elements/crowd";
import { matrixOf } from "../pose";
import type { MapPose } from "../tools";

/** The element at its edited pose, before it is written. */
export function Draft({ id, pose, colour }: { id: string; pose: MapPose; colour: Color }) {
  const matrix = useMemo(() => matrixOf(pose), [pose]);
  const shape = crowd.shapeOf(id);
  if (shape === null) return null;
  return (
    <group matrix={matrix} matrixAutoUpdate={false}>
      <mesh geometry={shape.geometry} renderOrder={1}>
        <meshLambertMaterial color={colour} transparent opacity={0.35} depthWrite={false} />
      </mesh>
      <lineSegments geometry={shape.edges}>
        <lineBasicMaterial color={colour} />
      </lineSegments>
    </group>
  );
}
