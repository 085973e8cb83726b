import { useQuery } from "@tanstack/react-query";
import { answer, api, type Schema } from "../api/client";
import { keys } from "../api/keys";
import { useSingleMutation } from "../api/mutations";
import { queryClient } from "../api/queries";
import { notifyProblem } from "../widgets/problems";

export type Alarm = Schema<"AlarmInfo">;

const ALL = 1000; // the server keeps no more past alarms

const NONE: readonly Alarm[] = [];

/** The active alarms, oldest first, or the past ones. */
export function useAlarms(active: boolean): readonly Alarm[] {
  const { data } = useQuery({
    queryKey: keys.alarms(active),
    queryFn: () => answer(api.GET("/api/v1/alarms", { params: { query: { active, limit: ALL } } })),
  });
  return data?.items ?? NONE;
}

/** Acknowledges an alarm. */
export function useAcknowledge() {
  return useSingleMutation({
    mutationFn: (alarm: Alarm) =>
      answer(api.POST("/api/v1/alarms/{alarm}/acknowledge", { params: { path: { alarm: alarm.id } } })),
    // Pending until the new state is fetched, so that its buttons cannot be pressed twice.
    onSuccess: () => queryClient.invalidateQueries({ queryKey: keys.alarms() }),
    onError: notifyProblem,
  });
}

/** Answers the question that an alarm asked when it was shown, not a later one. */
export function useAnswer() {
  return useSingleMutation({
    mutationFn: ({ alarm, choice }: { alarm: Alarm; choice: string }) =>
      answer(
        api.POST("/api/v1/alarms/{alarm}/answer", {
          params: { path: { alarm: alarm.id } },
          body: { answer: choice, question: alarm.question ?? null },
        }),
      ),
    // Pending until the new state is fetched, so that its buttons cannot be pressed twice.
    onSuccess: () => queryClient.invalidateQueries({ queryKey: keys.alarms() }),
    onError: notifyProblem,
  });
}
