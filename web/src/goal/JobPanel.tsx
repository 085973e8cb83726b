import { ActionIcon, Alert, Button, Group, List, Progress, Stack, Text, Title, Tooltip } from "@mantine/core";
import { IconCheck, IconListCheck, IconPlayerStop, IconX } from "@tabler/icons-react";
import { useMutation, useQuery } from "@tanstack/react-query";
import { useTranslation } from "react-i18next";
import { answer, api, ApiProblem, type Schema } from "../api/client";
import { keys } from "../api/keys";
import { useTab } from "../app/useTab";
import { MayButton } from "../widgets/MayButton";
import { notifyProblem } from "../widgets/problems";
import { type Mood, Status } from "../widgets/Status";
import classes from "./goal.module.css";
import { intoView } from "./intoView";
import { doneOf, type RunStep } from "./steps";
import { StepText } from "./StepText";

type Job = Schema<"Job">;

interface Props {
  id: string;
  onClose: () => void;
}

/** The job that was ordered last: what it does, how far it is, what came of it. */
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

function Course({ job }: { job: Job }) {
  const { t } = useTranslation("goal");
  const stop = useMutation({
    mutationFn: () => answer(api.POST("/api/v1/jobs/{id}/stop", { params: { path: { id: job.id } } })),
    onError: notifyProblem,
  });
  const said: Record<string, string> = t("job.states", { returnObjects: true });
  const states = ({ outcome, state }: Job) =>
    (outcome === null ? [state.text, ...state.substates] : [outcome]).map((one) => said[one] ?? one).join(" · ");
  return (
    <>
      <Group gap="xs">
        <Status mood={moodOf(job)} text={states(job)} />
        {job.detail && <Text size="sm">{job.detail}</Text>}
        {job.commands.includes("stop") && (
          <MayButton
            operation="stop_job"
            color="red"
            leftSection={<IconPlayerStop size={16} aria-hidden />}
            loading={stop.isPending}
            onClick={() => stop.mutate()}
            ml="auto"
          >
            {t("job.stop")}
          </MayButton>
        )}
      </Group>
      {job.outcome === null && job.plan.length > 0 && <Progressing id={job.id} />}
      <Answers job={job} />
      {job.reasons.length > 0 && (
        <Alert color={moodOf(job) === "good" ? "blue" : "red"}>
          <List size="sm">
            {job.reasons.map((reason) => (
              <List.Item key={reason}>{reason}</List.Item>
            ))}
          </List>
        </Alert>
      )}
      {job.conditions.length > 0 && <Ends conditions={job.conditions} />}
    </>
  );
}

function Progressing({ id }: { id: string }) {
  const { t } = useTranslation("goal");
  const path = { params: { path: { id } } };
  const { data } = useQuery({
    queryKey: keys.tasks("progress", id),
    queryFn: async () => {
      const [plan, report] = await Promise.all([
        answer(api.GET("/api/v1/jobs/{id}/plan", path)),
        answer(api.GET("/api/v1/jobs/{id}/report", path)),
      ]);
      return { plan: plan.steps, run: report.steps as unknown as RunStep[] };
    },
  });
  if (data === undefined || data.plan.length === 0) return null;
  const done = doneOf(data.plan, data.run);
  const running = data.run.filter(({ end }) => end === null);
  const text = t("job.progress", { done, all: data.plan.length });
  return (
    <Stack gap={2}>
      <Progress.Root size="lg">
        <Progress.Section value={(100 * done) / data.plan.length} aria-label={text} />
      </Progress.Root>
      <Text size="xs" c="dimmed">
        {text}
      </Text>
      {running.map((step, index) => (
        <Text key={index} size="sm">
          {t("job.now")} <StepText step={step} />
        </Text>
      ))}
    </Stack>
  );
}

/** What a held job waits for from a person. */
function Answers({ job }: { job: Job }) {
  const { t } = useTranslation("goal");
  const reply = useMutation({
    mutationFn: (choice: string) =>
      answer(
        api.POST("/api/v1/jobs/{id}/answer", {
          params: { path: { id: job.id } },
          body: { answer: choice, question: job.question },
        }),
      ),
    onError: notifyProblem,
  });
  if (job.choices.length === 0) return null;
  return (
    <Group gap="xs" role="group" aria-label={t("job.waits")}>
      <Text size="sm">{t("job.waits")}</Text>
      {job.choices.map((choice) => (
        <MayButton
          key={choice}
          operation="answer_job"
          variant="default"
          loading={reply.isPending}
          onClick={() => reply.mutate(choice)}
        >
          {choice}
        </MayButton>
      ))}
    </Group>
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
          {condition}
          {reason && `: ${reason}`}
        </List.Item>
      ))}
    </List>
  );
}

const GOOD = new Set(["succeeded", "goal already satisfied"]);

function moodOf({ outcome, state, choices }: Job): Mood {
  if (outcome !== null) return GOOD.has(outcome) ? "good" : outcome === "partially succeeded" ? "warning" : "bad";
  if (choices.length > 0) return "asking";
  if (state.text === "Interrupted") return "paused";
  return state.text === "Running" ? "running" : "waiting";
}
