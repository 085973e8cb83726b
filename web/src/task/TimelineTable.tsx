import { Button, Table, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { Status } from "../widgets/Status";
import type { Bar, TimelineLayout } from "./timelineLayout";
import type { Run } from "./trace";

interface Props {
  run: Run;
  layout: TimelineLayout;
  chosen: string | null;
  choose: (step: string) => void;
}

/** The timeline as a table. */
export function TimelineTable({ run, layout, chosen, choose }: Props) {
  const { t } = useTranslation("task");
  const rows = rowsOf(layout);
  return (
    <Table.ScrollContainer minWidth={420}>
      <Table withRowBorders verticalSpacing={2} aria-label={t("timeline.label")}>
        <Table.Thead>
          <Table.Tr>
            <Table.Th>{t("columns.agent")}</Table.Th>
            <Table.Th>{t("columns.step")}</Table.Th>
            <Table.Th>{t("columns.status")}</Table.Th>
            <Table.Th>{t("columns.start")}</Table.Th>
            <Table.Th>{t("columns.end")}</Table.Th>
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          {rows.map(({ agent, bar }) => (
            <Table.Tr key={bar.key} aria-selected={bar.step !== null && bar.step === chosen}>
              <Table.Td>{agent}</Table.Td>
              <Table.Td>
                <Title bar={bar} choose={choose} />
              </Table.Td>
              <Table.Td>
                <Status mood={bar.mood} text={t(bar.kind === "old" ? "givenUp" : `stepStates.${bar.state}`)} />
              </Table.Td>
              <Table.Td>{moment(bar.start - run.begun)}</Table.Td>
              <Table.Td>{moment(bar.end - run.begun)}</Table.Td>
            </Table.Tr>
          ))}
        </Table.Tbody>
      </Table>
    </Table.ScrollContainer>
  );
}

function Title({ bar, choose }: { bar: Bar; choose: (step: string) => void }) {
  const { step, title, attempt } = bar;
  const text = attempt > 1 ? `${title} (${attempt}×)` : title;
  if (step === null) return <Text size="sm">{text}</Text>;
  return (
    <Button variant="subtle" size="compact-xs" onClick={() => choose(step)}>
      {text}
    </Button>
  );
}

/** Executed, planned and abandoned steps by time; of the current plan, only those not started. */
function rowsOf(layout: TimelineLayout): { agent: string; bar: Bar }[] {
  return layout.lanes
    .flatMap(({ agent, bars }) => bars.filter(({ kind }) => kind !== "plan").map((bar) => ({ agent, bar })))
    .sort((one, other) => one.bar.start - other.bar.start);
}

function moment(seconds: number): string {
  return `${seconds.toFixed(1)} s`;
}
