/** The queries of the Modules tab. */

import { useQuery } from "@tanstack/react-query";
import { answer, api, type Schema } from "../api/client";
import { keys } from "../api/keys";
import { useMay } from "../api/session";
import type { Arguments } from "../widgets/ArgumentsForm";

export type Run = Schema<"ModuleRunInfo">;
export type Summary = Schema<"ModuleSummary">;

export function useModules() {
  return useQuery({
    queryKey: keys.modules("all"),
    queryFn: async () => (await answer(api.GET("/api/v1/modules"))).items,
  });
}

export function useModule(agent: string, module: string) {
  return useQuery({
    queryKey: keys.modules("one", agent, module),
    queryFn: () => answer(api.GET("/api/v1/modules/{agent}/{module}", { params: { path: { agent, module } } })),
    enabled: agent !== "",
  });
}

/** The arguments that a module would get now; fetched again when the world changes. */
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
