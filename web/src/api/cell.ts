/** Queries for the robots, devices, simulation and skills of the station. */

import { useQuery } from "@tanstack/react-query";
import { useMemo } from "react";
import { byName } from "../widgets/names";
import { answer, api, type Schema } from "./client";
import { keys } from "./keys";

export type Device = Schema<"DeviceInfo">;
export type RobotInfo = Schema<"RobotInfo">;
/** Skills by name. */
export type Skills = ReadonlyMap<string, Schema<"SkillInfo">>;

const byId = (one: { id: string }, other: { id: string }) => byName(one.id, other.id);

export function useRobots() {
  return useQuery({
    queryKey: keys.robots("all"),
    // Tuples lose their length there.
    queryFn: async () => ((await answer(api.GET("/api/v1/robots"))).items as RobotInfo[]).sort(byId),
  });
}

/** Devices of any kind; polled at an interval [ms] if one is given, because other clients may open and close them. */
export function useDevices(interval: number | false = false) {
  return useQuery({
    queryKey: keys.robots("devices"),
    queryFn: async () => ((await answer(api.GET("/api/v1/devices"))).items as Device[]).sort(byId),
    refetchInterval: interval,
  });
}

/** The simulation or fake behind the robots; polled at an interval [ms] if one is given. */
export function useSimulation(interval: number | false = false) {
  return useQuery({
    queryKey: keys.station("simulation"),
    queryFn: () => answer(api.GET("/api/v1/simulation")),
    refetchInterval: interval,
  });
}

/** Whether robots only pretend: their skills assert effects, and they stand where they are believed to be. */
export function usePretends(): boolean {
  return useSimulation().data?.driver === "fake";
}

export function useSkills(): Skills {
  const { data } = useQuery({
    queryKey: keys.modules("skills"),
    queryFn: async () => (await answer(api.GET("/api/v1/skills"))).items,
  });
  return useMemo(() => new Map(data?.map((skill) => [skill.name, skill])), [data]);
}
