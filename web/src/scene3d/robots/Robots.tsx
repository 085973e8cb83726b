import { useQuery } from "@tanstack/react-query";
import { answer, api } from "../../api/client";
import { keys } from "../../api/keys";
import type { Palette } from "../palette";
import { Robot, type RobotInfo } from "./Robot";

export function useRobots() {
  return useQuery({
    queryKey: keys.robots(),
    queryFn: async () => (await answer(api.GET("/api/v1/robots"))) as RobotInfo[],
  });
}

/** All robots of the station. */
export function Robots({ palette }: { palette: Palette }) {
  const { data } = useRobots();
  return data?.map((robot) => <Robot key={robot.id} robot={robot} palette={palette} />);
}
