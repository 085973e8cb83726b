import { useQuery } from "@tanstack/react-query";
import { answer, api } from "../api/client";
import { keys } from "../api/keys";

/** Whether, why, since when and by whom everything is halted; fetched again after events of the station. */
export function useHalt() {
  return useQuery({ queryKey: keys.station("stop"), queryFn: () => answer(api.GET("/api/v1/stop")) }).data;
}
