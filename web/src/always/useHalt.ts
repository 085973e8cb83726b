import { useQuery } from "@tanstack/react-query";
import { answer, api } from "../api/client";
import { keys } from "../api/keys";

/** Whether everything is halted, why, since when and by whom; read again when the station says something. */
export function useHalt() {
  return useQuery({ queryKey: keys.station("stop"), queryFn: () => answer(api.GET("/api/v1/stop")) }).data;
}
