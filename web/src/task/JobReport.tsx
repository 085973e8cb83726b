import { Button, Group, Stack, Table, Text } from "@mantine/core";
import { IconDownload, IconPrinter } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { answer, api, type Schema } from "../api/client";
import { GoalText } from "../goal/GoalText";
import { said } from "../i18n/sentences";
import { download } from "../widgets/download";
import { ElementName } from "../widgets/ElementName";
import { Moment } from "../widgets/Moment";
import { notifyProblem } from "../widgets/problems";
import { Status } from "../widgets/Status";
import { JobTimes } from "./JobTimes";
import { jobState, nothingDone } from "./jobWords";
import { usePrintedAlone } from "./printing";
import { asMarkdown } from "./report";
import type { Skills } from "../api/cell";
import { Section } from "./Section";
import type { Run } from "./trace";
import { useTransitions } from "./useRun";
import { jobMood, span, STEP_MOODS, stepState, stepTitle } from "./words";
import { ServerText } from "../goal/ServerText";

interface Props {
  job: Schema<"Job">;
  run: Run;
  skills: Skills;
}

const ID = "job-report";

/** The report of a job: conditions, parts, steps, states; can be printed and exported. */
export function JobReport({ job, run, skills }: Props) {
  const { t } = useTranslation("task");
  usePrintedAlone(ID, t("report.title", { id: job.id }));
  return (
    <Stack gap="sm" id={ID}>
      <Group gap={6} className="no-print">
        <Exports job={job} run={run} skills={skills} />
      </Group>
      <Heads job={job} />
      <Section title={t("report.conditions")}>
        <Conditions job={job} />
      </Section>
      <Section title={t("report.parts")}>
        <Parts job={job} />
      </Section>
      <Section title={t("report.steps")}>
        <Steps run={run} skills={skills} nothing={nothingDone(t, job.outcome)} />
      </Section>
      <Section title={t("report.states")}>
        <Transitions job={job} />
      </Section>
    </Stack>
  );
}

function Exports({ job, run, skills }: Props) {
  const { t } = useTranslation("task");
  const words = {
    title: t("report.title", { id: job.id }),
    outcome: jobState(t, job),
    goal: t("report.goal"),
    conditions: t("report.conditions"),
    reached: t("report.reached"),
    notReached: t("report.notReached"),
    parts: t("report.parts"),
    steps: t("report.steps"),
    done: t("stepStates.ended"),
    reasons: t("job.reasons"),
    gone: t("report.gone"),
  };
  const json = async () => {
    const response = await answer(api.GET("/api/v1/jobs/{id}/response", { params: { path: { id: job.id } } }));
    const report = await answer(api.GET("/api/v1/jobs/{id}/report", { params: { path: { id: job.id } } }));
    download(`${job.id}-report.json`, "application/json", JSON.stringify({ response, report }, null, 2));
  };
  const icon = <IconDownload size={14} aria-hidden />;
  return (
    <>
      <Button
        variant="default"
        leftSection={icon}
        onClick={() => download(`${job.id}-report.md`, "text/markdown", asMarkdown(job, run, skills, words))}
      >
        Markdown
      </Button>
      <Button variant="default" leftSection={icon} onClick={() => void json().catch(notifyProblem)}>
        JSON
      </Button>
      <Button variant="default" leftSection={<IconPrinter size={14} aria-hidden />} onClick={() => window.print()}>
        {t("report.print")}
      </Button>
    </>
  );
}

/** Data that the page shows above the report, repeated for the printed version. */
function Heads({ job }: { job: Schema<"Job"> }) {
  const { t } = useTranslation("task");
  return (
    <div className="only-on-paper">
      <Text fw={600}>
        <GoalText goal={job.order.goal} plain />
      </Text>
      <Text>{job.order.description}</Text>
      <Status mood={jobMood(job)} text={jobState(t, job)} />
      <JobTimes job={job} />
      {job.reasons.map((reason) => (
        <Text key={reason}>
          <ServerText text={reason} plain />
        </Text>
      ))}
    </div>
  );
}

function Conditions({ job }: { job: Schema<"Job"> }) {
  const { t } = useTranslation("task");
  if (job.conditions.length === 0) return <Text c="dimmed">{t("report.notYet")}</Text>;
  return (
    <Table verticalSpacing={2}>
      <Table.Tbody>
        {job.conditions.map(({ condition, reached, reason }) => (
          <Table.Tr key={condition}>
            <Table.Td>
              <GoalText goal={[condition]} />
            </Table.Td>
            <Table.Td>
              <Status mood={reached ? "good" : "bad"} text={t(reached ? "report.reached" : "report.notReached")} />
              {reason !== "" && (
                <Text size="sm">
                  <ServerText text={reason} />
                </Text>
              )}
            </Table.Td>
          </Table.Tr>
        ))}
      </Table.Tbody>
    </Table>
  );
}

function Parts({ job }: { job: Schema<"Job"> }) {
  const { t } = useTranslation("task");
  if (job.materials.length === 0) {
    // Moved parts are reported at the end of the job.
    return <Text c="dimmed">{t(job.ended === null ? "report.notYet" : "report.noParts")}</Text>;
  }
  return (
    <Table verticalSpacing={2}>
      <Table.Thead>
        <Table.Tr>
          <Table.Th>{t("report.part")}</Table.Th>
          <Table.Th>{t("report.from")}</Table.Th>
          <Table.Th>{t("report.to")}</Table.Th>
        </Table.Tr>
      </Table.Thead>
      <Table.Tbody>
        {job.materials.map(({ element, origin, place }) => (
          <Table.Tr key={element}>
            <Table.Td>
              <ElementName id={element} />
            </Table.Td>
            <Table.Td>{origin === "" ? "–" : <ElementName id={origin} />}</Table.Td>
            <Table.Td>{place === "" ? t("report.gone") : <ElementName id={place} />}</Table.Td>
          </Table.Tr>
        ))}
      </Table.Tbody>
    </Table>
  );
}

function Steps({ run, skills, nothing }: { run: Run; skills: Skills; nothing: string }) {
  const { t } = useTranslation("task");
  if (run.steps.length === 0) return <Text c="dimmed">{nothing}</Text>;
  return (
    <Table verticalSpacing={2}>
      <Table.Thead>
        <Table.Tr>
          <Table.Th>{t("columns.step")}</Table.Th>
          <Table.Th>{t("columns.agent")}</Table.Th>
          <Table.Th>{t("columns.status")}</Table.Th>
          <Table.Th>{t("report.time")}</Table.Th>
        </Table.Tr>
      </Table.Thead>
      <Table.Tbody>
        {run.steps.map((step) => (
          <Table.Tr key={step.key}>
            <Table.Td>{stepTitle(step, skills)}</Table.Td>
            <Table.Td>{step.agent}</Table.Td>
            <Table.Td>
              <Status mood={STEP_MOODS[stepState(step)]} text={t(`stepStates.${stepState(step)}`)} />
              {step.ended !== "ended" && step.ended !== null && (
                <Text size="sm">
                  <ServerText text={step.text} />
                </Text>
              )}
            </Table.Td>
            <Table.Td>{step.end === null ? "…" : span(step.end - step.start)}</Table.Td>
          </Table.Tr>
        ))}
      </Table.Tbody>
    </Table>
  );
}

function Transitions({ job }: { job: Schema<"Job"> }) {
  const { t } = useTranslation("task");
  const { data } = useTransitions(job);
  return (
    <Table verticalSpacing={2}>
      <Table.Tbody>
        {data?.items.map(({ at, state, comment, trigger }) => (
          <Table.Tr key={`${at} ${trigger}`}>
            <Table.Td>
              <Moment at={at} />
            </Table.Td>
            <Table.Td>{t(`jobStates.${state.text}`)}</Table.Td>
            <Table.Td>{said(comment)}</Table.Td>
          </Table.Tr>
        ))}
      </Table.Tbody>
    </Table>
  );
}
