import { useFrame } from "@react-three/fiber";
import { useQuery } from "@tanstack/react-query";
import { useEffect } from "react";
import { Matrix4 } from "three";
import type { URDFRobot } from "urdf-loader";
import { keys } from "../../api/keys";
import { devices } from "../devices";
import { bearTool } from "../frames";
import type { Palette } from "../palette";
import { wake } from "../ticker";
import { Footprint } from "./Footprint";
import { disposeModel, loadModel } from "./model";
import { models, noteCarrier, robotInMap } from "./models";
import type { RobotInfo } from "./useRobots";

/** A robot as its model draws it, moving live; its outline where there is no model. */
export function Robot({ robot, palette }: { robot: RobotInfo; palette: Palette }) {
  const { data: model } = useQuery({
    queryKey: keys.robotModels(robot.id, robot.model),
    queryFn: () => loadModel(robot.id),
    gcTime: 0,
  });
  useEffect(() => bearTools(robot, model ?? null), [robot, model]);
  useEffect(() => noteCarrier(robot), [robot]);
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

/** Lets what a device holds follow the link of the device that it is mounted on. */
function bearTools({ devices }: RobotInfo, model: URDFRobot | null): () => void {
  const endings = devices.map(({ id, mounted_on }) => {
    const link = model?.links[devices.find((one) => one.id === mounted_on)?.frames[0] ?? ""];
    return link === undefined ? () => undefined : bearTool(id, link);
  });
  return () => {
    for (const end of endings) end();
  };
}

const where = new Matrix4();

/** Puts a model and its joints where the devices say, whatever their kinds are. */
function pose(model: URDFRobot, robot: RobotInfo): void {
  for (const name in model.joints) {
    const position = devices.joints[`${robot.id}/${name}`]?.[0];
    if (position !== undefined) model.setJointValue(name, position);
  }
  if (robotInMap(robot, where)) where.decompose(model.position, model.quaternion, model.scale);
  model.updateMatrixWorld();
}
