import { useFrame } from "@react-three/fiber";
import { useQuery } from "@tanstack/react-query";
import { useEffect } from "react";
import type { URDFRobot } from "urdf-loader";
import { keys } from "../../api/keys";
import { devices } from "../devices";
import { bearTool } from "../frames";
import type { Palette } from "../palette";
import { wake } from "../ticker";
import { Footprint } from "./Footprint";
import { disposeModel, loadModel } from "./model";
import { baseOf, models } from "./models";
import type { RobotInfo } from "./useRobots";

/** A robot as its model draws it, moving live; its outline where there is no model. */
export function Robot({ robot, palette }: { robot: RobotInfo; palette: Palette }) {
  const { data: model } = useQuery({
    queryKey: keys.robotModels(robot.id, robot.model),
    queryFn: () => loadModel(robot.id),
    gcTime: 0,
  });
  useEffect(() => bearTools(robot, model ?? null), [robot, model]);
  useEffect(() => {
    if (!robot.base) return;
    baseOf.set(robot.id, robot.base.id);
    return () => void baseOf.delete(robot.id);
  }, [robot]);
  useEffect(() => {
    if (!model) return;
    models.set(robot.id, model);
    wake();
    return () => {
      models.delete(robot.id);
      disposeModel(model);
    };
  }, [robot.id, model]);
  useFrame(() => {
    if (model) pose(model, robot);
  }, -2);
  return (
    <>
      {model && <primitive object={model} userData={{ element: robot.id }} />}
      <Footprint robot={robot} palette={palette} solid={!model} />
    </>
  );
}

function bearTools(robot: RobotInfo, model: URDFRobot | null): () => void {
  const endings = robot.grippers.map(({ id, arm }) => {
    const tip = robot.arms.find((one) => one.id === arm)?.tip ?? "";
    return bearTool(id, arm, model?.links[tip] ?? null);
  });
  return () => {
    for (const end of endings) end();
  };
}

/** Puts the joints of a model where the devices are. */
function pose(model: URDFRobot, { arms, base, grippers, place }: RobotInfo): void {
  for (const { id, joints } of arms) {
    const angles = devices.arms[id];
    if (angles !== undefined) joints.forEach(({ name }, i) => model.setJointValue(name, angles[i] ?? 0));
  }
  for (const { id, joints = [] } of grippers) {
    const gap = devices.grippers[id]?.[0] ?? 0;
    for (const name of joints) model.setJointValue(name, gap / 2);
  }
  const localised = base ? devices.bases[base.id] : undefined;
  if (localised !== undefined) base?.joints?.forEach((name, i) => model.setJointValue(name, localised[i] ?? 0));
  if (place) {
    model.position.fromArray(place.position);
    model.quaternion.fromArray(place.orientation);
  }
  model.updateMatrixWorld();
}
