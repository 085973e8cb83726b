import { Progress as Bar, Stack, Text } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { useTranslation } from "react-i18next";
import { answer, api, ApiProblem, type Schema } from "../api/client";
import { keys } from "../api/keys";
import { doneOf } from "./steps";
import { StepText } from "./StepText";

/** Progress of a job in its plan and its current steps; empty before it starts. */
export function Progress({ job }: { job: string }) {
  const { t } = useTranslation("goal");
  const { data: task } = useQuery({ queryKey: keys.tasks("of job", job), queryFn: () => taskOf(job) });
  if (!task || task.plan.length === 0) return null;
  const done = doneOf(task.plan, task.steps);
  const text = t("job.progress", { done, all: task.plan.length });
  return (
    <Stack gap={2}>
      <Bar.Root size="lg">
        <Bar.Section value={(100 * done) / task.plan.length} aria-label={text} />
      </Bar.Root>
      <Text size="xs" c="dimmed">
        {text}
      </Text>
      {task.steps
        .filter(({ end }) => end === null)
        .map((step) => (
          <Text key={step.number} size="sm">
            {t("job.now")} <StepText step={step} />
          </Text>
        ))}
    </Stack>
  );
}

/** The task with the same id that executes a job; null while the job waits, for example after a restart. */
async function taskOf(job: string): Promise<Schema<"TaskInfo"> | null> {
  try {
    return await answer(api.GET("/api/v1/tasks/{name}", { params: { path: { name: job } } }));
  } catch (error) {
    if (error instanceof ApiProblem && error.status === 404) return null;
    throw error;
  }
}
