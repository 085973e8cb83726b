import { useFrame } from "@react-three/fiber";
import { useRef } from "react";
import { type Group, Matrix4 } from "three";
import { useSelection } from "../../selection/selection";
import { crowd } from "../elements/crowd";
import { frameInMap } from "../frames";
import { useLayers } from "../layers";
import { robotInMap } from "../robots/models";
import { useRobots } from "../../api/cell";

const LONG = 0.25; // m

/** Axes of the map, of robots and their tools, and of the selected element: x red, y green, z blue. */
export function Axes() {
  const shown = useLayers((layers) => layers.shown.axes);
  const selected = useSelection((state) => state.selected);
  const { data: robots = [] } = useRobots();
  if (!shown) return null;
  return (
    <>
      <axesHelper args={[2 * LONG]} />
      {robots.map((robot) => (
        <Cross key={robot.id} where={(into) => robotInMap(robot, into)} />
      ))}
      {robots.flatMap(({ devices }) =>
        devices
          .filter(({ mounted_on }) => mounted_on !== "")
          .map(({ id }) => <Cross key={id} where={(into) => frameInMap({ on: "tool", id }, into)} />),
      )}
      {selected !== null && <Cross where={(into) => crowd.poseOf(selected, into)} />}
    </>
  );
}

function Cross({ where }: { where: (into: Matrix4) => boolean }) {
  const group = useRef<Group>(null);
  useFrame(() => {
    if (group.current !== null) group.current.visible = where(group.current.matrix);
  });
  return (
    <group ref={group} matrixAutoUpdate={false}>
      <axesHelper args={[LONG]} />
    </group>
  );
}
