import { useFrame } from "@react-three/fiber";
import { useRef, useMemo, useEffect } from "react";
import type { Color, Group } from "three";
import { LineMaterial } from "three/examples/jsm/lines/LineMaterial.js";
import { LineSegments2 } from "three/examples/jsm/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/examples/jsm/lines/LineSegmentsGeometry.js";
import { useSelection } from "../selection/selection";
import { crowd } from "./elements/crowd";
import type { Palette } from "./palette";
import { type Shape, shapeIn } from "./shapes";
import { useShownView } from "./useShownView";

/** Outlines of what is selected, and of what the pointer is on. */
export function Highlight({ palette }: { palette: Palette }) {
  const selected = useSelection((state) => state.selected);
  const hovered = useSelection((state) => state.hovered);
  return (
    <>
      {selected !== null && <Outline key={selected} id={selected} colour={palette.selected} width={2.5} />}
      {hovered !== null && hovered !== selected && (
        <Outline key={hovered} id={hovered} colour={palette.hovered} width={1.5} />
      )}
    </>
  );
}

interface Props {
  id: string;
  colour: Color;
  width: number;
}

function Outline({ id, colour, width }: Props) {
  const view = useShownView();
  const group = useRef<Group>(null);
  const element = view?.elements.get(id);
  const shape = view && element ? shapeIn(view.shapes, element) : null;
  useFrame(() => {
    if (group.current !== null) group.current.visible = crowd.poseOf(id, group.current.matrix);
  });
  return (
    <group ref={group} matrixAutoUpdate={false}>
      {shape !== null && <Edges shape={shape} colour={colour} width={width} />}
    </group>
  );
}

function Edges({ shape, colour, width }: { shape: Shape; colour: Color; width: number }) {
  const lines = useMemo(() => {
    const material = new LineMaterial({ color: colour, linewidth: width });
    return new LineSegments2(new LineSegmentsGeometry().fromEdgesGeometry(shape.edges), material);
  }, [shape, colour, width]);
  useEffect(
    () => () => {
      lines.geometry.dispose();
      lines.material.dispose();
    },
    [lines],
  );
  return <primitive object={lines} />;
}
