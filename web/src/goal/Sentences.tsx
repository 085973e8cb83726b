import { ActionIcon, Alert, Button, Group, Stack, Text, Title, Tooltip } from "@mantine/core";
import { IconForms, IconRefresh, IconTable, IconTrash } from "@tabler/icons-react";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { AddCondition } from "./AddCondition";
import { KitTable } from "./KitTable";
import type { Verdict } from "./checks";
import { useDraft } from "./draft";
import classes from "./goal.module.css";
import { SceneGoals } from "./SceneGoals";
import { SentenceRow } from "./SentenceRow";
import { TextEditor } from "./TextEditor";
import { useWords } from "./words";

type View = "sentences" | "table" | "text";

/** The goal as a list of sentences, a table of a kit's places, or text. */
export function Sentences({ verdicts }: { verdicts: readonly Verdict[] }) {
  const { t } = useTranslation("goal");
  const { draft, addRows, setRows, setRow, removeRow, change } = useDraft();
  const { words, refetch, isFetching, known } = useWords();
  const [view, setView] = useState<View>("sentences");
  const show = (next: View) => setView(view === next ? "sentences" : next);
  return (
    <Stack gap="xs" component="section" aria-label={t("conditions")}>
      <Group justify="space-between" gap="xs">
        <Title order={3} size="h5">
          {t("conditions")}
        </Title>
        <Group gap={4}>
          <Button
            variant={view === "table" ? "filled" : "default"}
            size="compact-xs"
            aria-pressed={view === "table"}
            leftSection={<IconTable size={14} aria-hidden />}
            onClick={() => show("table")}
          >
            {t("kit.open")}
          </Button>
          <Button
            variant={view === "text" ? "filled" : "default"}
            size="compact-xs"
            aria-pressed={view === "text"}
            leftSection={<IconForms size={14} aria-hidden />}
            onClick={() => show("text")}
          >
            {t("asText.open")}
          </Button>
          <Tooltip label={t("refresh")}>
            <ActionIcon aria-label={t("refresh")} loading={isFetching} onClick={() => void refetch()}>
              <IconRefresh size={16} aria-hidden />
            </ActionIcon>
          </Tooltip>
          <Tooltip label={t("clear")}>
            <ActionIcon aria-label={t("clear")} disabled={draft.rows.length === 0} onClick={() => change({ rows: [] })}>
              <IconTrash size={16} aria-hidden />
            </ActionIcon>
          </Tooltip>
        </Group>
      </Group>
      {known && words.length === 0 && <Alert color="yellow">{t("noWords")}</Alert>}
      {view === "text" && (
        <TextEditor
          rows={draft.rows}
          onCancel={() => setView("sentences")}
          onDone={(rows) => {
            setRows(rows);
            setView("sentences");
          }}
        />
      )}
      {view === "table" && <KitTable words={words} verdicts={verdicts} />}
      {view === "sentences" && (
        <>
          {draft.rows.length === 0 && (
            <Text size="sm" c="dimmed">
              {t("empty")}
            </Text>
          )}
          <ul className={classes.rows} aria-label={t("conditions")}>
            {draft.rows.map((row, index) => (
              <SentenceRow
                key={row.key}
                row={row}
                word={row.kind === "word" ? words.find(({ name }) => name === row.word) : undefined}
                verdict={verdicts[index] ?? { state: "asking", why: "", conditions: [] }}
                onChange={setRow}
                onRemove={() => removeRow(row.key)}
              />
            ))}
          </ul>
          <AddCondition
            words={words}
            onAdd={({ name, roles }) =>
              addRows([{ kind: "word", word: name, arguments: roles.map(() => null), not: false }])
            }
          />
        </>
      )}
      <SceneGoals />
    </Stack>
  );
}
