import { Button, Group, Stack, Textarea } from "@mantine/core";
import { useMutation } from "@tanstack/react-query";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, api } from "../api/client";
import { problemText } from "../widgets/problems";
import { type NewRow, type Row, rowOf, textOf } from "./goals";

interface Props {
  rows: readonly Row[];
  onDone: (rows: NewRow[]) => void;
  onCancel: () => void;
}

/** The conditions as text, one per line, for users who know the goal language. */
export function TextEditor({ rows, onDone, onCancel }: Props) {
  const { t } = useTranslation(["goal", "common"]);
  const [text, setText] = useState(rows.map(textOf).join("\n"));
  const read = useMutation({ mutationFn: understood, onSuccess: onDone });
  return (
    <Stack gap="xs">
      <Textarea
        label={t("asText.label")}
        description={t("asText.help")}
        value={text}
        onChange={(event) => setText(event.currentTarget.value)}
        autosize
        minRows={4}
        maxRows={16}
        spellCheck={false}
        styles={{ input: { fontFamily: "monospace" }, error: { fontFamily: "monospace", whiteSpace: "pre-wrap" } }}
        error={read.error ? problemText(read.error) : undefined}
      />
      <Group gap="xs">
        <Button onClick={() => read.mutate(text)} loading={read.isPending}>
          {t("common:apply")}
        </Button>
        <Button variant="default" onClick={onCancel}>
          {t("common:cancel")}
        </Button>
      </Group>
    </Stack>
  );
}

/** Lets the server parse the text; conditions of a single word become sentences. */
export async function understood(text: string): Promise<NewRow[]> {
  const goal = text.split("\n").filter((line) => line.trim() !== "");
  if (goal.length === 0) return [];
  const body = { goal, work_master: "", materials: [] };
  const { conditions } = await answer(api.POST("/api/v1/goals/check", { body }));
  return conditions.map(rowOf);
}
