import { Button, Checkbox, Group, Select, Stack, Text, TextInput } from "@mantine/core";
import { IconDownload } from "@tabler/icons-react";
import { useDeferredValue, useMemo, useState } from "react";
import { useTranslation } from "react-i18next";
import { download } from "../widgets/download";
import { problemText } from "../widgets/problems";
import { asCsv } from "./exports";
import { type OutputRow, useOutput } from "./output";
import { OutputTable } from "./OutputTable";
import { byName } from "../widgets/names";

interface Props {
  /** Used in the names of exported files. */
  name: string;
  /** Time range of the messages [ms since 1970]; null for no limit. */
  from: number | null;
  to: number | null;
}

/** The messages of all modules, with filter and export. */
export function OutputPane({ name, from, to }: Props) {
  const { t } = useTranslation("task");
  const { rows, failed } = useOutput();
  const [text, setText] = useState("");
  const [agent, setAgent] = useState<string | null>(null);
  const [follow, setFollow] = useState(true);
  const [all, setAll] = useState(false);
  const wanted = useDeferredValue(text.trim().toLowerCase());
  const inTime = useMemo(
    () => (all ? rows : rows.filter((row) => (from === null || row.at >= from) && (to === null || row.at <= to))),
    [rows, all, from, to],
  );
  const agents = [...new Set(inTime.map((row) => row.agent))].filter(Boolean).sort(byName);
  const shown = inTime.filter((row) => (agent === null || row.agent === agent) && matches(row, wanted));
  return (
    <Stack gap="xs" h="100%">
      <Group gap="xs" align="end">
        <TextInput
          label={t("output.filter")}
          value={text}
          onChange={(event) => setText(event.currentTarget.value)}
          flex={1}
          miw={120}
        />
        <Select label={t("columns.agent")} data={agents} value={agent} onChange={setAgent} clearable w={120} />
        <Button
          variant="default"
          leftSection={<IconDownload size={14} aria-hidden />}
          onClick={() => download(`${name}-output.csv`, "text/csv", csv(shown))}
        >
          CSV
        </Button>
        <Button
          variant="default"
          leftSection={<IconDownload size={14} aria-hidden />}
          onClick={() => download(`${name}-output.json`, "application/json", JSON.stringify(shown, null, 1))}
        >
          JSON
        </Button>
      </Group>
      <Group gap="md">
        <Checkbox size="xs" label={t("output.follow")} checked={follow} onChange={() => setFollow(!follow)} />
        {from !== null && <Checkbox size="xs" label={t("output.all")} checked={all} onChange={() => setAll(!all)} />}
        <Text size="xs" c="dimmed" ml="auto">
          {t("output.count", { count: shown.length })}
        </Text>
      </Group>
      {failed !== null && <Text c="red">{problemText(failed)}</Text>}
      {shown.length === 0 ? (
        <Text c="dimmed">{t(rows.length === 0 ? "output.empty" : "output.nothing")}</Text>
      ) : (
        <OutputTable rows={shown} label={t("panes.output")} height="max(240px, 45vh)" follow={follow} />
      )}
    </Stack>
  );
}

function matches(row: OutputRow, wanted: string): boolean {
  return wanted === "" || `${row.module} ${row.caller} ${row.status} ${row.text}`.toLowerCase().includes(wanted);
}

function csv(rows: readonly OutputRow[]): string {
  const heads = ["time", "wall", "agent", "module", "caller", "status", "code", "description"];
  const cells = rows.map((row) => [
    row.time,
    new Date(row.at).toISOString(),
    row.agent,
    row.module,
    row.caller,
    row.status,
    row.code,
    row.text,
  ]);
  return asCsv(heads, cells);
}
