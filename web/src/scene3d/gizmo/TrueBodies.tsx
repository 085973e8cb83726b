import { useEffect, useMemo } from "react";
import { BufferAttribute, BufferGeometry, Vector3 } from "three";
import type { Schema } from "../../api/client";
import { crowd } from "../elements/crowd";
import type { Palette } from "../palette";
import { matrixOf } from "../pose";
import { type Shape, shapeOf } from "../shapes";
import { wake } from "../ticker";
import type { MapPose } from "../tools";
import { useLiveView, type View } from "../view";
import { useBodies } from "./useMovable";

type Body = Schema<"SimulatedBody">;

const point = new Vector3();

/** Outlines of all bodies at their true poses in the simulation. */
export function TrueBodies({ palette }: { palette: Palette }) {
  const bodies = useBodies();
  const view = useLiveView((state) => state.view);
  const geometry = useMemo(() => outlines(bodies, view), [bodies, view]);
  useEffect(() => {
    wake();
    return () => geometry.dispose();
  }, [geometry]);
  return (
    <lineSegments geometry={geometry} frustumCulled={false}>
      <lineBasicMaterial color={palette.truth} />
    </lineSegments>
  );
}

function outlines(bodies: readonly Body[], view: View | null): BufferGeometry {
  const places: number[] = [];
  for (const body of bodies) {
    const shape = shapeLike(body, view);
    if (shape !== null) addTo(places, shape, body);
  }
  return new BufferGeometry().setAttribute("position", new BufferAttribute(Float32Array.from(places), 3));
}

function shapeLike({ id, type }: Body, view: View | null): Shape | null {
  const blocks = view?.shapes[type];
  return crowd.shapeOf(id) ?? (blocks === undefined ? null : shapeOf(type, blocks));
}

function addTo(places: number[], { edges }: Shape, body: Body): void {
  const matrix = matrixOf(body as unknown as MapPose);
  const ends = edges.getAttribute("position");
  for (let i = 0; i < ends.count; i++)
    places.push(...point.fromBufferAttribute(ends, i).applyMatrix4(matrix).toArray());
}
