import { Anchor, Group, Progress, Stack, Table, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { ApiProblem } from "../../api/client";
import { useSelection } from "../../selection/selection";
import { moduleStatus } from "../../task/moduleWords";
import { Moment } from "../../widgets/Moment";
import { problemText } from "../../widgets/problems";
import { Status } from "../../widgets/Status";
import { type Run, useRun } from "../queries";
import { changeLines, shown } from "./changes";
import { RunControls } from "./RunControls";
import { isOver, MOODS, successRate } from "./states";
import { nameNow } from "../../widgets/names";
import { said } from "../../i18n/sentences";

/** One run: progress, reports, results of its rounds, and changes of the world. */
export function RunView({ id }: { id: string }) {
  const { t } = useTranslation("modules");
  const { data: run, error } = useRun(id);
  if (error instanceof ApiProblem && error.status === 404) return <Text size="sm">{t("run.gone", { id })}</Text>;
  if (run === undefined) return error && <Text size="sm">{problemText(error)}</Text>;
  return (
    <Stack gap="xs" role="region" aria-label={t("run.of", { module: run.module, id })}>
      <RunHeading run={run} />
      <RunControls run={run} />
      <Inputs run={run} />
      {run.repeat > 1 && <Rounds run={run} />}
      <Reports run={run} />
      <Changes run={run} />
    </Stack>
  );
}

export function RunHeading({ run }: { run: Run }) {
  const { t } = useTranslation("modules");
  const last = run.rounds.at(-1);
  return (
    <div>
      <Group gap="xs">
        <Text fw={600} size="sm">
          {run.module}
        </Text>
        <Text size="sm" c="dimmed">
          {run.agent} · <Moment at={run.started} /> · {run.by}
        </Text>
        <Status mood={MOODS[run.status]} text={t(`run.status.${run.status}`)} />
        {run.repeat > 1 && <Rate run={run} />}
      </Group>
      {last && isOver(run) && (
        <Text size="sm" role="status">
          {last.success ? said(last.text) : `${said(last.text)} (${last.code})`}
        </Text>
      )}
    </div>
  );
}

function Rate({ run }: { run: Run }) {
  const { t } = useTranslation("modules");
  const rate = successRate(run);
  return (
    <Text size="sm">
      {t("run.rounds", { done: run.done, repeat: run.repeat })}
      {rate !== null && ` · ${t("run.rate", { rate, succeeded: run.succeeded })}`}
    </Text>
  );
}

function Inputs({ run }: { run: Run }) {
  const { t } = useTranslation("modules");
  const given = Object.entries(run.arguments).filter(([, value]) => value !== null);
  if (given.length === 0) return null;
  return (
    <Text size="xs" c="dimmed">
      {given.map(([key, value]) => `${key} = ${shown(value)}${key in run.given ? "" : " *"}`).join(", ")}
      {given.some(([key]) => !(key in run.given)) && ` (${t("run.inferred")})`}
    </Text>
  );
}

function Rounds({ run }: { run: Run }) {
  const { t } = useTranslation("modules");
  return (
    <>
      <Progress
        value={(100 * run.done) / run.repeat}
        aria-label={t("run.rounds", { done: run.done, repeat: run.repeat })}
      />
      <details>
        <summary>{t("run.each")}</summary>
        <Table verticalSpacing={2} fz="xs">
          <Table.Tbody>
            {run.rounds.map((round, index) => (
              <Table.Tr key={round.start}>
                <Table.Td>{run.done - run.rounds.length + index + 1}</Table.Td>
                <Table.Td>
                  <RoundStatus success={round.success} cut={run.cut_off && index === run.rounds.length - 1} />
                </Table.Td>
                <Table.Td>{`${(round.end - round.start).toFixed(1)} s`}</Table.Td>
                <Table.Td>{said(round.text)}</Table.Td>
              </Table.Tr>
            ))}
          </Table.Tbody>
        </Table>
      </details>
    </>
  );
}

function RoundStatus({ success, cut }: { success: boolean; cut: boolean }) {
  const { t } = useTranslation("modules");
  if (cut) return <Status mood="stopped" text={t("run.status.stopped")} />;
  return <Status mood={success ? "good" : "bad"} text={t(success ? "run.status.succeeded" : "run.status.failed")} />;
}

const LATEST = 60;

function Reports({ run }: { run: Run }) {
  const { t } = useTranslation("modules");
  const { t: task } = useTranslation("task");
  if (run.progress.length === 0) return null;
  return (
    <Table.ScrollContainer minWidth={380} maxHeight={260}>
      <Table verticalSpacing={2} fz="xs" stickyHeader aria-label={t("run.progress")}>
        <Table.Thead>
          <Table.Tr>
            <Table.Th>{t("run.time")}</Table.Th>
            <Table.Th>{t("run.module")}</Table.Th>
            <Table.Th>{t("run.state")}</Table.Th>
            <Table.Th>{t("run.code")}</Table.Th>
            <Table.Th>{t("run.text")}</Table.Th>
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          {run.progress.slice(-LATEST).map((one, index) => (
            <Table.Tr key={`${one.time} ${index}`}>
              <Table.Td style={{ whiteSpace: "nowrap" }}>{`${one.time.toFixed(1)} s`}</Table.Td>
              <Table.Td pl={one.caller ? "md" : undefined}>{one.module}</Table.Td>
              <Table.Td>{moduleStatus(task, one.status)}</Table.Td>
              <Table.Td>{one.code}</Table.Td>
              <Table.Td>{said(one.text)}</Table.Td>
            </Table.Tr>
          ))}
        </Table.Tbody>
      </Table>
    </Table.ScrollContainer>
  );
}

function Changes({ run }: { run: Run }) {
  const { t } = useTranslation("modules");
  const choose = useSelection((selection) => selection.choose);
  const lines = changeLines(run.changes);
  if (lines.length === 0) return null;
  return (
    <details>
      <summary>{t("run.changes", { count: lines.length })}</summary>
      <Stack gap={2} mt={4}>
        {lines.map(({ key, element, text }) => (
          <Text key={key} size="xs">
            {element && (
              <Anchor component="button" inherit onClick={() => choose(element)}>
                {nameNow(element)}
              </Anchor>
            )}{" "}
            {text}
          </Text>
        ))}
      </Stack>
    </details>
  );
}
