import { Alert, Anchor, Button, Group, Loader, Stack, Text, Title } from "@mantine/core";
import { IconHistory, IconListNumbers } from "@tabler/icons-react";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import type { Schema } from "../api/client";
import { useSingleMutation } from "../api/mutations";
import { GoalText } from "../goal/GoalText";
import { showReplay, useReplay } from "../scene3d/replay";
import { notifyProblem } from "../widgets/problems";
import { Status } from "../widgets/Status";
import { forget, useIsGone } from "./removedJobs";
import { JobCommands } from "./JobCommands";
import { JobReport } from "./JobReport";
import { NewSequenceButton } from "./NewSequenceButton";
import { Paused } from "./Paused";
import { Problem } from "./Problem";
import { Question } from "./Question";
import { ReplayBar } from "./ReplayBar";
import { RunPanes } from "./RunPanes";
import { TakeUp } from "./TakeUp";
import type { Run } from "./trace";
import { useJob, useJobRun } from "./useRun";
import { useSkills } from "../api/cell";
import { jobMood } from "./words";
import { JobTimes } from "./JobTimes";
import { jobState, nothingDone } from "./jobWords";
import { ServerText } from "../goal/ServerText";

/** One job, present or past. */
export function JobView({ id }: { id: string }) {
  const { t } = useTranslation("task");
  const gone = useIsGone(id);
  if (gone) return <Text role="status">{t("job.removed", { id })}</Text>;
  return <There id={id} />;
}

function There({ id }: { id: string }) {
  const { data: job, error, refetch } = useJob(id);
  if (error !== null && job === undefined) return <Problem error={error} again={refetch} />;
  if (job === undefined) return null;
  return <Known job={job} />;
}

function Known({ job }: { job: Schema<"Job"> }) {
  const { t } = useTranslation("task");
  const [chosen, choose] = useState<string | null>(null);
  const skills = useSkills();
  const { run, error, isPending, refetch } = useJobRun(job);
  const state = { mood: jobMood(job), text: jobState(t, job) };
  const goal = job.order.goal.join(", ");
  return (
    <Stack gap="xs" component="article" aria-label={t("job.label", { id: job.id })}>
      <Group gap="xs">
        <Title order={3} size="h5" fw={600}>
          <GoalText goal={job.order.goal} />
        </Title>
        <Status {...state} />
        {job.late && <Status mood="warning" text={t("job.late")} />}
      </Group>
      <Text size="xs" c="dimmed">
        {job.id}
      </Text>
      {job.order.description !== "" && <Text size="sm">{job.order.description}</Text>}
      <JobTimes job={job} />
      <Reasons job={job} />
      <Paused job={job} />
      <Question job={job} />
      <Group gap={6}>
        <JobCommands job={job} gone={() => forget(job.id)} />
        {job.started !== null && <ReplayButton job={job.id} />}
        {job.plan.length > 0 && <NewSequenceButton job={job.id} title={job.id} icon={IconListNumbers} />}
      </Group>
      <Replayed job={job.id} run={run} choose={choose} />
      {error !== null && <Problem error={error} again={refetch} />}
      <RunPanes
        key={job.id}
        name={job.id}
        run={run}
        skills={skills}
        title={goal}
        state={state}
        paused={job.state.text === "Interrupted"}
        from={moment(job.started)}
        to={moment(job.ended)}
        report={<JobReport job={job} run={run} skills={skills} />}
        nothing={isPending ? t("loading", { ns: "common" }) : nothingDone(t, job.outcome)}
        chosen={chosen}
        choose={choose}
      />
    </Stack>
  );
}

function moment(at: string | null): number | null {
  return at === null ? null : Date.parse(at);
}

function Reasons({ job }: { job: Schema<"Job"> }) {
  const { t } = useTranslation("task");
  if (job.reasons.length === 0) return null;
  return (
    <Alert color="red" p="xs" title={t("job.reasons")}>
      {job.reasons.map((reason) => (
        <Text key={reason} size="sm">
          <ServerText text={reason} />
        </Text>
      ))}
      {job.outcome === "no plan" && <TakeUp goal={job.order.goal} />}
    </Alert>
  );
}

function ReplayButton({ job }: { job: string }) {
  const { t } = useTranslation("task");
  const shown = useReplay(({ replay }) => replay?.job === job);
  const { mutate, isPending } = useSingleMutation({
    mutationFn: () => showReplay(job),
    onError: notifyProblem,
  });
  // One button for both, never disabled, so that it keeps the keyboard focus.
  return (
    <Button
      variant={shown ? "light" : "default"}
      leftSection={isPending ? <Loader size={14} /> : <IconHistory size={14} aria-hidden />}
      aria-busy={isPending}
      onClick={() => (shown ? useReplay.getState().set({ replay: null, speed: 0 }) : mutate())}
    >
      {t(shown ? "replay.leave" : "replay.show")}
    </Button>
  );
}

/** The replay controls of this job, or a note that another job is replayed. */
function Replayed({ job, run, choose }: { job: string; run: Run; choose: (step: string) => void }) {
  const { t } = useTranslation("task");
  const shown = useReplay(({ replay }) => replay?.job);
  if (shown === undefined) return null;
  if (shown === job) return <ReplayBar steps={run.steps} choose={choose} />;
  return (
    <Alert color="blue" p="xs">
      <Anchor href={`#/task/${encodeURIComponent(shown)}`}>{t("replay.other", { job: shown })}</Anchor>
    </Alert>
  );
}
