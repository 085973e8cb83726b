import { useQuery } from "@tanstack/react-query";
import { answer, api, type Schema } from "../api/client";
import { keys } from "../api/keys";
import { useSingleMutation } from "../api/mutations";
import { queryClient } from "../api/queries";
import { notifyProblem } from "../widgets/problems";

export type Alarm = Schema<"AlarmInfo">;

const ALL = 1000; // no more are kept of those that are over

const NONE: readonly Alarm[] = [];

/** The alarms that are active, oldest first, or those that are over. */
export function useAlarms(active: boolean): readonly Alarm[] {
  const { data } = useQuery({
    queryKey: keys.alarms(active),
    queryFn: () => answer(api.GET("/api/v1/alarms", { params: { query: { active, limit: ALL } } })),
  });
  return data?.items ?? NONE;
}

/** Notes that an alarm was seen. */
export function useAcknowledge() {
  return useSingleMutation({
    mutationFn: (alarm: Alarm) =>
      answer(api.POST("/api/v1/alarms/{alarm}/acknowledge", { params: { path: { alarm: alarm.id } } })),
    // Until it is known what that has made of the alarm, its buttons are not there for a second press.
    onSuccess: () => queryClient.invalidateQueries({ queryKey: keys.alarms() }),
    onError: notifyProblem,
  });
}

/** Answers what an alarm asks: that, and nothing that it may ask by then. */
export function useAnswer() {
  return useSingleMutation({
    mutationFn: ({ alarm, choice }: { alarm: Alarm; choice: string }) =>
      answer(
        api.POST("/api/v1/alarms/{alarm}/answer", {
          params: { path: { alarm: alarm.id } },
          body: { answer: choice, question: alarm.question ?? null },
        }),
      ),
    // Until it is known what that has made of the alarm, its buttons are not there for a second press.
    onSuccess: () => queryClient.invalidateQueries({ queryKey: keys.alarms() }),
    onError: notifyProblem,
  });
}
