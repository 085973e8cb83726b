import { useQuery } from "@tanstack/react-query";
import { answer, api, type Schema } from "../../api/client";
import { keys } from "../../api/keys";

export type RobotInfo = Schema<"RobotInfo">;

/** What the robots of the station are made of. */
export function useRobots() {
  return useQuery({
    queryKey: keys.robots(),
    queryFn: async () => (await answer(api.GET("/api/v1/robots"))) as RobotInfo[],
  });
}
