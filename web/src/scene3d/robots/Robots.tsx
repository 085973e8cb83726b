import type { Palette } from "../palette";
import { Robot } from "./Robot";
import { useRobots } from "./useRobots";

/** All robots of the station. */
export function Robots({ palette }: { palette: Palette }) {
  const { data } = useRobots();
  return data?.map((robot) => <Robot key={robot.id} robot={robot} palette={palette} />);
}
