/** Previews of plans, which are not executed. */

import { useQuery } from "@tanstack/react-query";
import { answer, api, ApiProblem, type Schema } from "../api/client";
import { useSingleMutation } from "../api/mutations";
import { notifyProblem } from "../widgets/problems";
import { useDraft } from "./draft";
import type { GoalOrder } from "./goals";

export type Preview = Schema<"Preview">;

const WAIT = 10; // s: the server answers as soon as the plan is ready
const PAUSE = 300; // ms

/** Requests a plan, and follows it until it is ready. */
export function usePreview(order: GoalOrder | null) {
  const { draft, change } = useDraft();
  const asked = draft.preview;
  const ask = useSingleMutation({
    mutationFn: (wanted: GoalOrder) => answer(api.POST("/api/v1/previews", { body: wanted })),
    onSuccess: ({ id, asked: at }, wanted) =>
      change({ preview: { id, asked: at ?? "", order: JSON.stringify(wanted) } }),
    onError: notifyProblem,
  });
  const { data, error, isPending } = useQuery({
    queryKey: ["previews", asked?.id, asked?.asked],
    queryFn: ({ signal }) => look(asked?.id ?? "", asked?.asked ?? "", signal),
    enabled: asked !== null,
    refetchInterval: ({ state }) => (state.data?.state === "planning" ? PAUSE : false),
  });
  return {
    /** Requests a plan, for the current goal unless another is given. */
    ask: (wanted: GoalOrder | null = order) => wanted !== null && ask.mutate(wanted),
    preview: data,
    /** The server no longer keeps it. */
    lost: error instanceof ApiProblem,
    planning: ask.isPending || (asked !== null && isPending) || data?.state === "planning",
    /** It is the plan for the current goal. */
    fits: asked !== null && asked.order === JSON.stringify(order),
  };
}

async function look(id: string, asked: string, signal: AbortSignal): Promise<Preview> {
  const params = { path: { id }, query: { wait: WAIT } };
  const preview = await answer(api.GET("/api/v1/previews/{id}", { params, signal }));
  if (preview.asked !== asked) throw new ApiProblem(404, undefined); // of another run of the server
  return preview;
}
