/** Queries for the robots, devices and skills of the station. */

import { useQuery } from "@tanstack/react-query";
import { useMemo } from "react";
import { answer, api, type Schema } from "./client";
import { keys } from "./keys";

export type Device = Schema<"DeviceInfo">;
export type RobotInfo = Schema<"RobotInfo">;
/** Skills by name. */
export type Skills = ReadonlyMap<string, Schema<"SkillInfo">>;

export function useRobots() {
  return useQuery({
    queryKey: keys.robots("all"),
    queryFn: async () => (await answer(api.GET("/api/v1/robots"))) as RobotInfo[], // tuples lose their length there
  });
}

/** Devices of any kind; polled at an interval [ms] if one is given, because other clients may open and close them. */
export function useDevices(interval: number | false = false) {
  return useQuery({
    queryKey: keys.robots("devices"),
    queryFn: async () => (await answer(api.GET("/api/v1/devices"))) as Device[],
    refetchInterval: interval,
  });
}

export function useSkills(): Skills {
  const { data } = useQuery({ queryKey: keys.modules("skills"), queryFn: () => answer(api.GET("/api/v1/skills")) });
  return useMemo(() => new Map(data?.map((skill) => [skill.name, skill])), [data]);
}
