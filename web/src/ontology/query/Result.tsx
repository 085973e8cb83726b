import { Button, Code, Group, Stack, Table, Text } from "@mantine/core";
import { IconDownload } from "@tabler/icons-react";
import { useMutation } from "@tanstack/react-query";
import { useMemo, useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, api, type Schema } from "../../api/client";
import { download } from "../../widgets/download";
import { notifyProblem } from "../../widgets/problems";
import { Status } from "../../widgets/Status";
import { Cell, useKnown } from "./Cell";

type SelectAnswer = Schema<"SelectAnswer">;
export type Answer = SelectAnswer | Schema<"AskAnswer"> | Schema<"ConstructAnswer">;

interface Props {
  result: Answer;
  query: string;
  entailed: boolean;
  limit: number;
}

/** What a question was answered. */
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

function Rows({ result, ...asked }: { result: SelectAnswer } & Omit<Props, "result">) {
  const { t } = useTranslation("ontology");
  const [shown, setShown] = useState(FEW);
  const known = useKnown();
  const rows = useMemo(() => result.rows.slice(0, shown), [result, shown]);
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
              {result.variables.map((name) => (
                <Table.Th key={name}>{name}</Table.Th>
              ))}
            </Table.Tr>
          </Table.Thead>
          <Table.Tbody>
            {rows.map((row, index) => (
              <Table.Tr key={index}>
                {result.variables.map((name) => (
                  <Table.Td key={name}>
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

/** The server writes the file: it knows how values are told in CSV. */
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
