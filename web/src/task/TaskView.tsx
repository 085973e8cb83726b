import { Alert, Group, Stack, Text, Title } from "@mantine/core";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import type { Schema } from "../api/client";
import { Moment } from "../widgets/Moment";
import { Status } from "../widgets/Status";
import { nothingDone } from "./jobWords";
import { Problem } from "./Problem";
import { roundsOf, withRound } from "./rounds";
import { RunPanes } from "./RunPanes";
import { Section } from "./Section";
import { TaskCommands } from "./TaskCommands";
import { taskState } from "./taskWords";
import type { Run } from "./trace";
import { useTask, useTaskRun } from "./useRun";
import { useSkills } from "../api/cell";
import { taskMood } from "./words";
import { said } from "../i18n/sentences";

/** A task without a job: a running sequence, or a goal started directly. */
export function TaskView({ name }: { name: string }) {
  const { data: task, error, refetch } = useTask(name);
  if (error !== null && task === undefined) return <Problem error={error} again={refetch} />;
  if (task === undefined) return null;
  return <Known task={task} />;
}

function Known({ task }: { task: Schema<"TaskInfo"> }) {
  const { t } = useTranslation("task");
  const [chosen, choose] = useState<string | null>(null);
  const skills = useSkills();
  const { run: fetched, error, isPending, refetch } = useTaskRun(task.name);
  const run = withRound(fetched, task.goal.length > 0 ? [] : task.plan);
  const state = { mood: taskMood(task), text: taskState(t, task) };
  const title = task.goal.join(", ") || t("task.sequence", { count: task.plan.length });
  return (
    <Stack gap="xs" component="article" aria-label={t("task.label", { name: task.name })}>
      <Group gap="xs">
        <Title order={3} size="h4">
          {task.name}
        </Title>
        <Status {...state} />
      </Group>
      <Text size="sm">{title}</Text>
      <Text size="sm" c="dimmed">
        {t("task.begun", { by: task.by })} <Moment at={task.begun} />
      </Text>
      {task.goal.length === 0 && <Rate run={run} steps={task.plan.length} />}
      {task.question !== null && (
        <Alert color="orange" p="xs">
          {said(task.question.text)} {t("task.above")}
        </Alert>
      )}
      {task.report?.fault && (
        <Alert color="red" p="xs" title={t("job.reasons")}>
          {said(task.report.fault)}
        </Alert>
      )}
      <TaskCommands task={task} />
      {error !== null && <Problem error={error} again={refetch} />}
      <RunPanes
        key={task.name}
        name={task.name}
        run={run}
        skills={skills}
        title={title}
        state={state}
        paused={task.status === "paused"}
        from={Date.parse(task.begun)}
        to={null}
        report={<TaskReport task={task} />}
        nothing={isPending ? t("loading", { ns: "common" }) : nothingDone(t, task.report?.outcome ?? null)}
        chosen={chosen}
        choose={choose}
      />
    </Stack>
  );
}

function Rate({ run, steps }: { run: Run; steps: number }) {
  const { t } = useTranslation("task");
  const { done, tried, worked } = roundsOf(run, steps);
  const rate = tried === 0 ? "–" : `${Math.round((100 * worked) / tried)} %`;
  return (
    <Text size="sm" role="status">
      {`${t("task.rounds", { count: done })}; ${t("task.rate", { worked, count: tried, rate })}`}
    </Text>
  );
}

function TaskReport({ task: { report } }: { task: Schema<"TaskInfo"> }) {
  const { t } = useTranslation("task");
  if (report === null) return <Text c="dimmed">{t("report.notYet")}</Text>;
  return (
    <Stack gap="sm">
      <Text size="sm">{t("task.used", { simulated: report.simulated.toFixed(1), wall: report.wall.toFixed(1) })}</Text>
      <Section title={t("report.conditions")}>
        {report.conditions.map((condition, index) => (
          <Group key={`${String(condition.condition)} ${index}`} gap="xs">
            <Status
              mood={condition.believed === true ? "good" : "bad"}
              text={t(condition.believed === true ? "report.reached" : "report.notReached")}
            />
            <Text size="sm">{`${String(condition.condition)} ${said(String(condition.reason ?? ""))}`}</Text>
          </Group>
        ))}
      </Section>
      {report.no_plan.map((reason) => (
        <Text key={reason} size="sm">
          {said(reason)}
        </Text>
      ))}
    </Stack>
  );
}
