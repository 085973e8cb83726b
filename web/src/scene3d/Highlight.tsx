import { useFrame } from "@react-three/fiber";
import { useEffect, useMemo, useRef } from "react";
import type { Color, Group } from "three";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";
import { useSelection } from "../selection/selection";
import { crowd } from "./elements/crowd";
import type { Palette } from "./palette";
import { type Shape, shapeIn } from "./shapes";
import { wake } from "./ticker";
import { useShownView } from "./useShownView";

/** Outlines of the selected element and of the one under the pointer. */
export function Highlight({ palette }: { palette: Palette }) {
  const selected = useSelection((state) => state.selected);
  const hovered = useSelection((state) => state.hovered);
  return (
    <>
      {selected !== null && <Outline key={selected} id={selected} lines={STRONG} colour={palette.selected} />}
      {hovered !== null && hovered !== selected && (
        <Outline key={hovered} id={hovered} lines={FINE} colour={palette.hovered} />
      )}
    </>
  );
}

// Kept permanently: a new material would compile its shader again for each element.
const STRONG = new LineMaterial({ linewidth: 2.5 });
const FINE = new LineMaterial({ linewidth: 1.5 });

interface Props {
  id: string;
  lines: LineMaterial;
  colour: Color;
}

function Outline({ id, lines, colour }: Props) {
  const view = useShownView();
  const group = useRef<Group>(null);
  const element = view?.elements.get(id);
  const shape = view && element ? shapeIn(view.shapes, element) : null;
  useFrame(() => {
    if (group.current !== null) group.current.visible = crowd.poseOf(id, group.current.matrix);
  });
  return (
    <group ref={group} matrixAutoUpdate={false}>
      {shape !== null && <Edges shape={shape} lines={lines} colour={colour} />}
    </group>
  );
}

function Edges({ shape, lines, colour }: { shape: Shape; lines: LineMaterial; colour: Color }) {
  const edges = useMemo(
    () => new LineSegments2(new LineSegmentsGeometry().fromEdgesGeometry(shape.edges), lines),
    [shape, lines],
  );
  useEffect(() => {
    edges.material.color.copy(colour);
    wake();
  }, [edges, colour]);
  useEffect(() => () => edges.geometry.dispose(), [edges]);
  return <primitive object={edges} />;
}
