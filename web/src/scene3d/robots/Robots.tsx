import { type Device, useDevices, useRobots } from "../../api/cell";
import type { Palette } from "../palette";
import { matrixOf } from "../pose";
import { DrawnModel } from "./DrawnModel";
import { useModel } from "./model";
import { Robot } from "./Robot";

/** All robots of the station, and all devices with a model of their own. */
export function Robots({ palette }: { palette: Palette }) {
  const { data: robots = [] } = useRobots();
  const { data: devices = [] } = useDevices();
  return (
    <>
      {robots.map((robot) => (
        <Robot key={robot.id} robot={robot} palette={palette} />
      ))}
      {devices
        .filter(({ model }) => model !== "")
        .map((device) => (
          <SingleDevice key={device.id} device={device} />
        ))}
    </>
  );
}

function SingleDevice({ device: { id, model: name, place } }: { device: Device }) {
  const model = useModel(id, name);
  return model && place && <DrawnModel id={id} model={model} where={(into) => matrixOf(place, into) === into} />;
}
