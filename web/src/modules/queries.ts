/** What the tab reads. */

import { useQuery } from "@tanstack/react-query";
import { useEffect } from "react";
import { answer, api, type Schema } from "../api/client";
import { keys } from "../api/keys";
import { queryClient } from "../api/queries";
import { useMay } from "../api/session";
import { useStation } from "../live/station";
import type { Arguments } from "../widgets/ArgumentsForm";

export type Run = Schema<"ModuleRunInfo">;
export type Summary = Schema<"ModuleSummary">;

export function useModules() {
  return useQuery({ queryKey: keys.modules("all"), queryFn: () => answer(api.GET("/api/v1/modules")) });
}

export function useModule(agent: string, module: string) {
  return useQuery({
    queryKey: keys.modules("one", agent, module),
    queryFn: () => answer(api.GET("/api/v1/modules/{agent}/{module}", { params: { path: { agent, module } } })),
    enabled: agent !== "",
  });
}

export function useRobots() {
  return useQuery({ queryKey: keys.robots("all"), queryFn: () => answer(api.GET("/api/v1/robots")) });
}

export type Robot = NonNullable<ReturnType<typeof useRobots>["data"]>[number];

/** What a module would be run with now; read again when the world changes. */
export function usePanel(agent: string, module: string, values: Arguments) {
  const may = useMay("show_panel");
  return useQuery({
    queryKey: keys.world("panel", agent, module, values),
    queryFn: () =>
      answer(
        api.POST("/api/v1/modules/{agent}/{module}/panel", {
          params: { path: { agent, module } },
          body: { arguments: values },
        }),
      ),
    enabled: may,
    placeholderData: (before, query) => (query?.queryKey[3] === module ? before : undefined),
  });
}

export function useRuns() {
  return useQuery({
    queryKey: keys.moduleRuns("all"),
    queryFn: async () => (await answer(api.GET("/api/v1/module-runs", { params: { query: { limit: 200 } } }))).items,
  });
}

export function useRun(id: string | null) {
  return useQuery({
    queryKey: keys.moduleRuns("one", id),
    queryFn: () => answer(api.GET("/api/v1/module-runs/{id}", { params: { path: { id: id ?? "" } } })),
    enabled: id !== null,
  });
}

/** Has runs read again when somebody pauses one, which makes no event: the state of the robots tells it. */
export function useFreshRuns(): void {
  const atWork = useStation((station) => modulesAtWork(station.state));
  useEffect(() => void queryClient.invalidateQueries({ queryKey: keys.moduleRuns() }), [atWork]);
}

function modulesAtWork(state: Schema<"StationState"> | null): string {
  return (state?.modules ?? []).map(({ agent, module, status }) => `${agent} ${module} ${status}`).join("\n");
}
