import { ScrollArea, Table } from "@mantine/core";
import { useVirtualizer } from "@tanstack/react-virtual";
import { useEffect, useRef } from "react";
import { useTranslation } from "react-i18next";
import { Status } from "../widgets/Status";
import type { OutputRow } from "./output";
import { moduleMood } from "./tree";
import { moduleStatus } from "./moduleWords";
import { said } from "../i18n/sentences";

interface Props {
  rows: readonly OutputRow[];
  label: string;
  height: number | string;
  /** Scrolls to each new row. */
  follow?: boolean;
}

const ROW = 28; // px
const CELL = { paddingBlock: 0, whiteSpace: "nowrap", overflow: "hidden", textOverflow: "ellipsis" } as const;

/** The messages of modules, as in the output table of the paper; only visible rows are rendered. */
export function OutputTable({ rows, label, height, follow = false }: Props) {
  const { t } = useTranslation("task");
  const viewport = useRef<HTMLDivElement>(null);
  // The virtualizer returns functions that cannot be memoized; nothing here is.
  // eslint-disable-next-line react-hooks/incompatible-library
  const virtual = useVirtualizer({
    count: rows.length,
    getScrollElement: () => viewport.current,
    estimateSize: () => ROW,
    overscan: 12,
  });
  const last = rows.length - 1;
  useEffect(() => {
    if (follow && last >= 0) virtual.scrollToIndex(last);
  }, [follow, last, virtual]);
  const items = virtual.getVirtualItems();
  const before = items[0]?.start ?? 0;
  const after = virtual.getTotalSize() - (items.at(-1)?.end ?? 0);
  return (
    <ScrollArea h={height} viewportRef={viewport} viewportProps={{ tabIndex: 0, role: "region", "aria-label": label }}>
      <Table stickyHeader layout="fixed" miw={520} aria-label={label} aria-rowcount={rows.length + 1}>
        <Table.Thead>
          <Table.Tr>
            <Table.Th w={72} style={CELL}>
              {t("columns.time")}
            </Table.Th>
            <Table.Th w={112}>{t("columns.module")}</Table.Th>
            <Table.Th w={112}>{t("columns.status")}</Table.Th>
            <Table.Th w={46}>{t("columns.code")}</Table.Th>
            <Table.Th>{t("columns.description")}</Table.Th>
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          <Space height={before} />
          {items.map(({ index }) => {
            const row = rows[index];
            return row && <Row key={row.id} row={row} index={index} />;
          })}
          <Space height={after} />
        </Table.Tbody>
      </Table>
    </ScrollArea>
  );
}

function Space({ height }: { height: number }) {
  if (height <= 0) return null;
  return (
    <tr aria-hidden>
      <td style={{ height, padding: 0 }} />
    </tr>
  );
}

function Row({ row, index }: { row: OutputRow; index: number }) {
  const { t } = useTranslation("task");
  return (
    <Table.Tr h={ROW} aria-rowindex={index + 2}>
      <Table.Td style={CELL}>{row.time.toFixed(2)}</Table.Td>
      <Table.Td style={CELL} title={`${row.agent}: ${row.caller && `${row.caller} → `}${row.module}`}>
        {row.caller === "" ? <b>{row.module}</b> : row.module}
      </Table.Td>
      <Table.Td style={CELL}>
        <Status mood={moduleMood(row.status)} text={moduleStatus(t, row.status)} />
      </Table.Td>
      <Table.Td style={CELL}>{row.code}</Table.Td>
      <Table.Td style={CELL} title={said(row.text)}>
        {said(row.text)}
      </Table.Td>
    </Table.Tr>
  );
}
