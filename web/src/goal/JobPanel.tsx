import { ActionIcon, Alert, Box, Button, Group, List, Stack, Text, Title, Tooltip } from "@mantine/core";
import { IconCheck, IconListCheck, IconX } from "@tabler/icons-react";
import { useQuery } from "@tanstack/react-query";
import { useTranslation } from "react-i18next";
import { answer, api, ApiProblem, type Schema } from "../api/client";
import { keys } from "../api/keys";
import { useTab } from "../app/useTab";
import { Status } from "../widgets/Status";
import { JobCommands } from "../task/JobCommands";
import { jobState } from "../task/jobWords";
import { Question } from "../task/Question";
import { jobMood } from "../task/words";
import classes from "./goal.module.css";
import { intoView } from "../widgets/intoView";
import { GoalText } from "./GoalText";
import { Progress } from "./Progress";
import { ServerText } from "./ServerText";
import { said } from "../i18n/sentences";

type Job = Schema<"Job">;

interface Props {
  id: string;
  onClose: () => void;
}

/** The last job that was ordered: its activity, progress and result. */
export function JobPanel({ id, onClose }: Props) {
  const { t } = useTranslation("goal");
  const [, open] = useTab();
  const { data: job, error } = useQuery({
    queryKey: keys.jobs("one", id),
    queryFn: () => answer(api.GET("/api/v1/jobs/{id}", { params: { path: { id } } })),
  });
  const gone = error instanceof ApiProblem && (error.status === 404 || error.status === 410);
  return (
    <Stack
      gap="xs"
      component="section"
      aria-label={t("job.title")}
      aria-live="polite"
      ref={intoView}
      className={classes.result}
    >
      <Group justify="space-between" wrap="nowrap">
        <Title order={3} size="h5" style={{ overflowWrap: "anywhere" }}>
          {t("job.named", { id })}
        </Title>
        <Group gap={4} wrap="nowrap">
          <Button
            variant="default"
            leftSection={<IconListCheck size={14} aria-hidden />}
            onClick={() => open("task", id)}
          >
            {t("job.open")}
          </Button>
          <Tooltip label={t("job.dismiss")}>
            <ActionIcon aria-label={t("job.dismiss")} onClick={onClose}>
              <IconX size={16} aria-hidden />
            </ActionIcon>
          </Tooltip>
        </Group>
      </Group>
      {gone && <Text size="sm">{t("job.gone")}</Text>}
      {job && !gone && <Course job={job} />}
    </Stack>
  );
}

/** Details that repeat the state; others are shown next to it. */
const SAID = new Set(["", "queued", "planning", "running", "paused", "waits for leave to start"]);

function Course({ job }: { job: Job }) {
  const { t } = useTranslation("task");
  return (
    <>
      <Group gap="xs">
        <Status mood={jobMood(job)} text={jobState(t, job)} />
        {job.choices.length === 0 && !SAID.has(job.detail) && <Text size="sm">{said(job.detail)}</Text>}
        <Box ml="auto">
          <JobCommands job={job} only="stop" />
        </Box>
      </Group>
      {job.outcome === null && job.plan.length > 0 && <Progress job={job.id} />}
      <Question job={job} />
      {job.reasons.length > 0 && (
        <Alert color={jobMood(job) === "good" ? "blue" : "red"}>
          <List size="sm">
            {job.reasons.map((reason) => (
              <List.Item key={reason}>
                <ServerText text={reason} />
              </List.Item>
            ))}
          </List>
        </Alert>
      )}
      {job.conditions.length > 0 && <Ends conditions={job.conditions} />}
    </>
  );
}

function Ends({ conditions }: { conditions: Job["conditions"] }) {
  const { t } = useTranslation("goal");
  return (
    <List size="sm" spacing={2} aria-label={t("job.conditions")} listStyleType="none">
      {conditions.map(({ condition, reached, reason }) => (
        <List.Item
          key={condition}
          icon={
            reached ? (
              <IconCheck size={16} color="var(--mantine-color-green-text)" aria-label={t("job.reached")} role="img" />
            ) : (
              <IconX size={16} color="var(--mantine-color-red-text)" aria-label={t("job.notReached")} role="img" />
            )
          }
        >
          <GoalText goal={[condition]} />
          {reason && (
            <>
              : <ServerText text={reason} />
            </>
          )}
        </List.Item>
      ))}
    </List>
  );
}
