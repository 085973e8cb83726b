import { useFrame } from "@react-three/fiber";
import { useEffect } from "react";
import { Matrix4 } from "three";
import type { URDFRobot } from "urdf-loader";
import { devices } from "../devices";
import { wake } from "../ticker";
import { addModel } from "./models";

interface Props {
  id: string;
  model: URDFRobot;
  /** Writes its pose in the map; false if unknown. */
  where: (into: Matrix4) => boolean;
}

/** The model of a robot, or of a device without a robot, with live or replayed joint positions. */
export function DrawnModel({ id, model, where }: Props) {
  useEffect(() => {
    const remove = addModel(id, model);
    wake();
    return remove;
  }, [id, model]);
  useFrame(() => {
    for (const name in model.joints) {
      const position = devices.joints[`${id}/${name}`]?.[0];
      if (position !== undefined) model.setJointValue(name, position);
    }
    if (where(matrix)) matrix.decompose(model.position, model.quaternion, model.scale);
    model.updateMatrixWorld();
  }, -2);
  return <primitive object={model} userData={{ element: id }} />;
}

const matrix = new Matrix4();
