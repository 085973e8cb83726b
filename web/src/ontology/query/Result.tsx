import { Button, Code, Group, Stack, Table, Text, UnstyledButton } from "@mantine/core";
import { IconChevronDown, IconChevronUp, IconDownload, IconSelector } from "@tabler/icons-react";
import { useMutation } from "@tanstack/react-query";
import { useMemo, useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, api, type Schema } from "../../api/client";
import { download } from "../../widgets/download";
import { notifyProblem } from "../../widgets/problems";
import { Status } from "../../widgets/Status";
import { Cell, useKnown } from "./Cell";
import { columns, type Order, sorted } from "./console";

type SelectAnswer = Schema<"SelectAnswer">;
export type Answer = SelectAnswer | Schema<"AskAnswer"> | Schema<"ConstructAnswer">;

interface Props {
  result: Answer;
  query: string;
  entailed: boolean;
  limit: number;
}

/** The answer to a query. */
export function Result({ result, ...asked }: Props) {
  const { t } = useTranslation("ontology");
  switch (result.form) {
    case "ASK":
      return (
        <div role="status">
          <Status mood={result.answer ? "good" : "bad"} text={result.answer ? t("yes") : t("no")} />
        </div>
      );
    case "CONSTRUCT":
      return <Turtle turtle={result.turtle} count={result.statements.length} />;
    default:
      return <Rows result={result} {...asked} />;
  }
}

function Turtle({ turtle, count }: { turtle: string; count: number }) {
  const { t } = useTranslation("ontology");
  return (
    <Stack gap={6}>
      <Group gap="xs">
        <Text size="sm" role="status">
          {t("query.statements", { count })}
        </Text>
        <Button
          variant="default"
          leftSection={<IconDownload size={14} aria-hidden />}
          onClick={() => download("answer.ttl", "text/turtle", turtle)}
        >
          {t("query.turtle")}
        </Button>
      </Group>
      <Code block tabIndex={0}>
        {turtle}
      </Code>
    </Stack>
  );
}

const FEW = 200;
const COLUMN = 110; // px: narrower columns would break words

function Rows({ result, ...asked }: { result: SelectAnswer } & Omit<Props, "result">) {
  const { t } = useTranslation("ontology");
  const [shown, setShown] = useState(FEW);
  const known = useKnown();
  const [order, setOrder] = useState<Order | null>(null);
  const names = useMemo(() => columns(asked.query, result.variables), [asked.query, result]);
  const rows = useMemo(() => sorted(result.rows, order).slice(0, shown), [result, order, shown]);
  return (
    <Stack gap={6}>
      <Group gap="xs">
        <Text size="sm" role="status">
          {t("query.rows", { count: result.rows.length })}
        </Text>
        <CsvButton {...asked} />
      </Group>
      <Table.ScrollContainer minWidth={300}>
        <Table aria-label={t("query.result")} striped verticalSpacing={2}>
          <Table.Thead>
            <Table.Tr>
              {names.map((name) => (
                <Heading key={name} name={name} order={order} sort={setOrder} />
              ))}
            </Table.Tr>
          </Table.Thead>
          <Table.Tbody>
            {rows.map((row, index) => (
              <Table.Tr key={index}>
                {names.map((name) => (
                  <Table.Td key={name} miw={COLUMN}>
                    <Cell value={row[name]} known={known} />
                  </Table.Td>
                ))}
              </Table.Tr>
            ))}
          </Table.Tbody>
        </Table>
      </Table.ScrollContainer>
      {result.rows.length > shown && (
        <Button variant="default" onClick={() => setShown(shown + 5 * FEW)}>
          {t("query.more")}
        </Button>
      )}
    </Stack>
  );
}

interface HeadingProps {
  name: string;
  order: Order | null;
  sort: (order: Order | null) => void;
}

/** The header of a column; pressing it sorts ascending, descending, or not at all. */
function Heading({ name, order, sort }: HeadingProps) {
  const mine = order?.column === name ? order : null;
  const next = mine === null ? { column: name, falling: false } : mine.falling ? null : { ...mine, falling: true };
  const Icon = mine === null ? IconSelector : mine.falling ? IconChevronDown : IconChevronUp;
  return (
    <Table.Th aria-sort={mine === null ? "none" : mine.falling ? "descending" : "ascending"}>
      <UnstyledButton fz="sm" fw={700} onClick={() => sort(next)}>
        {name} <Icon size={12} aria-hidden />
      </UnstyledButton>
    </Table.Th>
  );
}

/** The server writes the file, since it knows the CSV notation of values. */
function CsvButton({ query, entailed, limit }: Omit<Props, "result">) {
  const { t } = useTranslation("ontology");
  const fetch = useMutation({
    mutationFn: () =>
      answer(
        api.POST("/api/v1/queries", {
          body: { query, bindings: {}, entailed, time_limit: limit },
          headers: { Accept: "text/csv" },
          parseAs: "text",
        }),
      ),
    onSuccess: (text) => download("answer.csv", "text/csv", String(text)),
    onError: notifyProblem,
  });
  return (
    <Button
      variant="default"
      leftSection={<IconDownload size={14} aria-hidden />}
      loading={fetch.isPending}
      onClick={() => fetch.mutate()}
    >
      {t("query.csv")}
    </Button>
  );
}
