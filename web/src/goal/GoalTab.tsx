import { Group, Loader, Stack, Title, VisuallyHidden } from "@mantine/core";
import { useEffect, useMemo } from "react";
import { useTranslation } from "react-i18next";
import { useSingleMutation } from "../api/mutations";
import { queryClient } from "../api/queries";
import { useGhosts } from "../scene3d/ghosts";
import { useVerdict, useVerdicts, type Verdict } from "./checks";
import { type Draft, useDraft, useSceneName } from "./draft";
import { ghostsOf } from "./ghosts";
import { goalOrder } from "./goals";
import { JobPanel } from "./JobPanel";
import { PreviewPanel } from "./PreviewPanel";
import { usePreview } from "./preview";
import { RunBar } from "./RunBar";
import { Sentences } from "./Sentences";
import { TemplateChoice } from "./TemplateChoice";
import { TemplateForm } from "./TemplateForm";
import {
  reverseTemplate,
  type Template,
  templateOrder,
  TEMPLATES,
  useTemplateChanges,
  useTemplates,
} from "./templates";
import { useFreshWords } from "./words";
import { useHistoryOf } from "../widgets/history";
import { HistoryButtons } from "../widgets/HistoryButtons";

/** The Goal tab: state, check, plan, order and follow a goal. */
export default function GoalTab() {
  const { t } = useTranslation();
  const scene = useSceneName();
  if (scene === undefined) return <Loader size="sm" aria-label={t("loading")} />;
  return <Goal key={scene} />;
}

function Goal() {
  const { t } = useTranslation("goal");
  const { draft, change } = useDraft();
  const history = useGoalHistory(draft, change);
  const wanted = useWanted(draft);
  const { order, verdicts, template } = wanted;
  const preview = usePreview(order);
  const conditions = verdicts.flatMap((verdict) => verdict.conditions);
  useShownGhosts(verdicts);
  useFreshWords();
  return (
    <Stack gap="md">
      <VisuallyHidden>
        <Title order={2}>{t("title")}</Title>
      </VisuallyHidden>
      <TemplateChoice verdicts={verdicts} />
      <Group gap="xs">
        <HistoryButtons operation="check_goal" {...history} />
      </Group>
      {template && draft.template ? (
        <TemplateForm template={template} filled={draft.template} verdict={wanted.whole} />
      ) : (
        <Sentences verdicts={verdicts} />
      )}
      {draft.preview && (
        <PreviewPanel key={draft.preview.asked} {...preview} conditions={conditions} again={preview.ask} />
      )}
      {draft.job && <JobPanel key={draft.job} id={draft.job} onClose={() => change({ job: null })} />}
      <RunBar order={order} planning={preview.planning} onPreview={() => preview.ask()} />
    </Stack>
  );
}

/** The order that the draft makes, and the server's verdict on its conditions. */
function useWanted(draft: Draft) {
  const templates = useTemplates();
  const template: Template | undefined = templates.find(({ name }) => name === draft.template?.name);
  const filled = template && draft.template ? templateOrder(draft.template, template.content) : null;
  const whole = useVerdict(filled);
  const each = useVerdicts(draft.template ? [] : draft.rows);
  const order = draft.template ? filled : goalOrder(draft.rows);
  return { order, whole, template, verdicts: draft.template ? [whole] : each };
}

/** Undo and redo of what a person edits as the goal, and of the changes of templates. */
function useGoalHistory({ rows, template }: Draft, change: (goal: Pick<Draft, "rows" | "template">) => void) {
  const count = useTemplateChanges((changes) => changes.count);
  const reverse = useSingleMutation({
    mutationFn: reverseTemplate,
    onSettled: () => queryClient.invalidateQueries({ queryKey: TEMPLATES }),
  });
  const history = useHistoryOf(
    { rows, template, count },
    (past) => {
      useTemplateChanges.setState({ count: past.count });
      change({ rows: past.rows, template: past.template });
    },
    (past) => reverse.mutateAsync(past.count),
  );
  return { ...history, busy: reverse.isPending };
}

function useShownGhosts(verdicts: readonly Verdict[]): void {
  const json = JSON.stringify(ghostsOf(verdicts.flatMap(({ conditions }) => conditions)));
  const ghosts = useMemo(() => JSON.parse(json) as ReturnType<typeof ghostsOf>, [json]);
  useEffect(() => useGhosts.getState().show(ghosts), [ghosts]);
}
