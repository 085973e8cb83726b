import { useEffect } from "react";
import type { URDFRobot } from "urdf-loader";
import type { RobotInfo } from "../../api/cell";
import { bearTool } from "../frames";
import type { Palette } from "../palette";
import { Footprint } from "./Footprint";
import { DrawnModel } from "./DrawnModel";
import { useModel } from "./model";
import { noteCarrier, robotInMap } from "./models";

/** A robot with its live model, or its footprint without a model. */
export function Robot({ robot, palette }: { robot: RobotInfo; palette: Palette }) {
  const model = useModel(robot.id, robot.model);
  useEffect(() => bearTools(robot, model), [robot, model]);
  useEffect(() => noteCarrier(robot), [robot]);
  return (
    <>
      {model && <DrawnModel id={robot.id} model={model} where={(into) => robotInMap(robot, into)} />}
      <Footprint robot={robot} palette={palette} solid={!model} />
    </>
  );
}

/** Lets objects held by a device follow the link on which the device is mounted. */
function bearTools({ devices }: RobotInfo, model: URDFRobot | null): () => void {
  const endings = devices.map(({ id, mounted_on }) => {
    const link = model?.links[devices.find((one) => one.id === mounted_on)?.frames[0] ?? ""];
    return link === undefined ? () => undefined : bearTool(id, link);
  });
  return () => {
    for (const end of endings) end();
  };
}
