import { Alert, Checkbox, Group, NumberInput, Select, Stack, Text } from "@mantine/core";
import { IconPlayerPlay } from "@tabler/icons-react";
import { useMutation } from "@tanstack/react-query";
import { useMemo, useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, api } from "../../api/client";
import { useMay } from "../../api/session";
import { MayButton } from "../../widgets/MayButton";
import { problemText } from "../../widgets/problems";
import { useClasses } from "../../world/classes";
import { useProperties, useRelations } from "../../world/queries";
import classes from "../../world/World.module.css";
import { history, placeOf, remember } from "./console";
import { Editor } from "./Editor";
import { EXAMPLES, type ExampleName, PREFIXES } from "./examples";
import { type Answer, Result } from "./Result";

const [USUAL_LIMIT, LONGEST] = [5, 60]; // s

/** SPARQL queries over ontology, scene and learned concepts; read-only. */
export default function QueryConsole() {
  const { t } = useTranslation("ontology");
  const [query, setQuery] = useState<string>(() => history()[0] ?? EXAMPLES.where);
  const [entailed, setEntailed] = useState(false);
  const [limit, setLimit] = useState(USUAL_LIMIT);
  const [asked, setAsked] = useState(history);
  const may = useMay("ask_question");
  const asking = useMutation({
    mutationFn: (text: string) => ask(text, entailed, limit),
    onMutate: (text) => setAsked(remember(text)),
  });
  const run = () => may && query.trim() !== "" && asking.mutate(query);
  const trouble = asking.error === null ? "" : problemText(asking.error);
  const place = useMemo(() => placeOf(trouble), [trouble]);
  return (
    <Stack gap="xs" className={classes.scroll} pr={4}>
      <Beginnings asked={asked} onChoose={setQuery} />
      <Editor label={t("query.text")} value={query} onChange={setQuery} onRun={run} names={useNames()} error={place} />
      <Group gap="md">
        <MayButton
          operation="ask_question"
          leftSection={<IconPlayerPlay size={14} aria-hidden />}
          loading={asking.isPending}
          onClick={run}
        >
          {t("query.run")}
        </MayButton>
        <Text size="xs" c="dimmed">
          {t("query.keys")}
        </Text>
        <Checkbox
          size="xs"
          label={t("query.entailed")}
          checked={entailed}
          onChange={(event) => setEntailed(event.currentTarget.checked)}
        />
        <NumberInput
          w={150}
          aria-label={t("query.limit")}
          prefix={t("query.limitPrefix")}
          suffix=" s"
          min={1}
          max={LONGEST}
          value={limit}
          onChange={(value) => setLimit(Number(value) || USUAL_LIMIT)}
        />
      </Group>
      {trouble && (
        <Alert color="red" title={t("query.refused")} style={{ overflowWrap: "anywhere" }}>
          {trouble}
        </Alert>
      )}
      {asking.data && <Result result={asking.data} query={asking.variables} entailed={entailed} limit={limit} />}
    </Stack>
  );
}

/** The answer is JSON unless another format is chosen. */
function ask(query: string, entailed: boolean, limit: number): Promise<Answer> {
  const body = { query, bindings: {}, entailed, time_limit: limit };
  return answer(api.POST("/api/v1/queries", { body })) as Promise<Answer>;
}

function useNames(): string[] {
  const known = useClasses();
  const relations = useRelations().data ?? [];
  const properties = useProperties().data ?? [];
  const terms = [...relations, ...properties].map(({ name }) => name);
  return [...PREFIXES, ...new Set([...known.keys(), ...terms])];
}

function Beginnings({ asked, onChoose }: { asked: readonly string[]; onChoose: (query: string) => void }) {
  const { t } = useTranslation("ontology");
  const examples = Object.keys(EXAMPLES) as ExampleName[];
  return (
    <Group gap="xs" grow>
      <Select
        aria-label={t("query.examples")}
        placeholder={t("query.examples")}
        data={examples.map((value) => ({ value, label: t(`query.example.${value}`) }))}
        value={null}
        onChange={(name) => name && onChoose(EXAMPLES[name as ExampleName])}
      />
      <Select
        aria-label={t("query.history")}
        placeholder={t("query.history")}
        data={asked.map((value) => ({ value, label: value.replace(/\s+/g, " ").slice(0, 90) }))}
        value={null}
        nothingFoundMessage={t("query.noHistory")}
        onChange={(value) => value && onChoose(value)}
      />
    </Group>
  );
}
