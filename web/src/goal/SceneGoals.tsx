import { Alert, Button, Group, List, Modal, Stack, Text } from "@mantine/core";
import { notifications } from "@mantine/notifications";
import { useQuery } from "@tanstack/react-query";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { answerWithTag, api, ApiProblem } from "../api/client";
import { keys } from "../api/keys";
import { useSingleMutation } from "../api/mutations";
import { queryClient } from "../api/queries";
import { MayButton } from "../widgets/MayButton";
import { notifyProblem } from "../widgets/problems";
import { useDraft } from "./draft";
import { type Goal, goalOf } from "./goals";
import { understood } from "./TextEditor";
import { said } from "../i18n/sentences";

const KEY = keys.goals("scene");

interface Write {
  goals: Goal[];
  tag: string;
}

/** The goals stored with the scene: load and save them. */
export function SceneGoals() {
  const { t } = useTranslation("goal");
  const { draft, setRows } = useDraft();
  const { data } = useQuery({ queryKey: KEY, queryFn: () => answerWithTag(api.GET("/api/v1/goals")) });
  const [seen, setSeen] = useState<string>(); // the version that was displayed, regardless of later ones
  if (seen === undefined && data !== undefined) setSeen(data.tag);
  const take = useSingleMutation({
    mutationFn: ({ goals }: { goals: readonly string[]; tag: string }) => understood(goals.join("\n")),
    onSuccess: (rows, { tag }) => {
      setRows(rows);
      setSeen(tag);
    },
    onError: notifyProblem,
  });
  const write = useSingleMutation({
    mutationFn: ({ goals, tag }: Write) =>
      answerWithTag(api.PUT("/api/v1/goals", { body: { goals }, params: { header: { "if-match": tag } } })),
    onSuccess: ({ tag }) => {
      setSeen(tag);
      notifications.show({ message: t("scene.saved") });
    },
    onError: (error) => (isStale(error) ? undefined : notifyProblem(error)),
    onSettled: () => queryClient.invalidateQueries({ queryKey: KEY }),
  });
  const theirs = data?.data.goals ?? [];
  const ours = draft.rows.map(goalOf);
  const complete = ours.filter((goal) => goal !== null);
  const ready = complete.length > 0 && complete.length === ours.length;
  const save = (tag: string | undefined) => write.mutate({ goals: complete, tag: tag ?? "" });
  return (
    <Stack gap={4}>
      <Group gap="xs">
        <Button
          variant="default"
          disabled={theirs.length === 0}
          loading={take.isPending}
          onClick={() => take.mutate({ goals: theirs, tag: data?.tag ?? "" })}
        >
          {t("scene.take", { count: theirs.length })}
        </Button>
        <MayButton
          operation="put_goals"
          variant="default"
          disabled={!ready}
          loading={write.isPending}
          onClick={() => save(seen)}
        >
          {t("scene.save")}
        </MayButton>
      </Group>
      {data?.data.fault && <Alert color="yellow">{t("scene.fault", { fault: said(data.data.fault) })}</Alert>}
      <Modal opened={isStale(write.error)} onClose={write.reset} title={t("scene.changed")}>
        <Stack>
          <Text size="sm">{t("scene.changedHelp")}</Text>
          <List size="sm">
            {theirs.map((goal) => (
              <List.Item key={goal}>{goal}</List.Item>
            ))}
          </List>
          <Group>
            <Button onClick={() => save(data?.tag)}>{t("scene.replace")}</Button>
            <Button variant="default" onClick={write.reset}>
              {t("scene.leave")}
            </Button>
          </Group>
        </Stack>
      </Modal>
    </Stack>
  );
}

function isStale(error: unknown): boolean {
  return error instanceof ApiProblem && error.status === 412;
}
