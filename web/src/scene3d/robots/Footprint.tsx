import { Line } from "@react-three/drei";
import { useFrame } from "@react-three/fiber";
import { useMemo, useRef } from "react";
import { ExtrudeGeometry, type Group, Matrix4, Shape, Vector2 } from "three";
import { useSelection } from "../../selection/selection";
import type { Palette } from "../palette";
import { headingOf, poseOf } from "../pose";
import { robotInMap } from "./models";
import type { RobotInfo } from "../../api/cell";

const HEIGHT = 0.35; // m, of a robot whose model is missing
const MARGIN = 1.2;

interface Props {
  robot: RobotInfo;
  palette: Palette;
  /** Draws a body, for a robot whose model is missing or not loaded yet. */
  solid: boolean;
}

/** The footprint of a robot: marks the selection, and replaces a missing model. */
export function Footprint({ robot, palette, solid }: Props) {
  const group = useRef<Group>(null);
  const selected = useSelection((state) => state.selected === robot.id);
  const hovered = useSelection((state) => state.hovered === robot.id);
  const corners = useMemo(() => outline(robot), [robot]);
  useFrame(() => {
    if (!robotInMap(robot, where)) return;
    const pose = poseOf(where);
    group.current?.position.set(pose.position[0], pose.position[1], 0);
    group.current?.rotation.set(0, 0, headingOf(pose));
  }, -2);
  return (
    <group ref={group} userData={{ element: robot.id }}>
      {(selected || hovered) && (
        <Line points={corners} color={selected ? palette.selected : palette.hovered} lineWidth={selected ? 4 : 2} />
      )}
      {solid && <Body robot={robot} palette={palette} />}
    </group>
  );
}

const where = new Matrix4();

function Body({ robot, palette }: { robot: RobotInfo; palette: Palette }) {
  const geometry = useMemo(() => {
    const shape = new Shape(robot.footprint.map(([x, y]) => new Vector2(x, y)));
    return new ExtrudeGeometry(shape, { depth: HEIGHT, bevelEnabled: false });
  }, [robot]);
  return (
    <mesh geometry={geometry}>
      <meshLambertMaterial color={palette.kinds.robot} />
    </mesh>
  );
}

function outline(robot: RobotInfo): [number, number, number][] {
  const corners = robot.footprint.map(([x, y]): [number, number, number] => [x * MARGIN, y * MARGIN, 0.01]);
  return [...corners, ...corners.slice(0, 1)];
}
