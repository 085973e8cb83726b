import { useTab } from "../app/useTab";
import { useSingleMutation } from "../api/mutations";
import { notifyProblem } from "../widgets/problems";
import { useDraft } from "./draft";
import { goalOrder, keyed } from "./goals";
import { usePreview } from "./preview";
import { understood } from "./TextEditor";

/** Opens the goal of a job: its conditions become the draft and are planned, to show what is wrong. */
export function useTakeUp() {
  const { draft, change, setRows } = useDraft();
  const [, open] = useTab();
  const preview = usePreview(null);
  const take = useSingleMutation({
    mutationFn: (goal: readonly string[]) => understood(goal.join("\n")),
    onSuccess: (rows) => {
      setRows(rows);
      change({ job: null });
      preview.ask(goalOrder(keyed(rows)));
      open("goal");
    },
    onError: notifyProblem,
  });
  return { take: take.mutate, busy: take.isPending, overwrites: draft.rows.length > 0 || draft.template !== null };
}
