import { type ComboboxItem, Select, Stack, Text } from "@mantine/core";
import { IconPlus } from "@tabler/icons-react";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { said } from "../i18n/sentences";
import type { ConditionWord } from "./sentence";
import { useSentence } from "./words";

interface Props {
  words: readonly ConditionWord[];
  onAdd: (word: ConditionWord) => void;
}

/** Chooses the condition to add, by sentence, name or meaning. */
export function AddCondition({ words, onAdd }: Props) {
  const { t } = useTranslation("goal");
  const piecesOf = useSentence();
  const [search, setSearch] = useState("");
  const byName = new Map(words.map((word) => [word.name, word]));
  const spoken = (word: ConditionWord) =>
    piecesOf(word)
      .map((piece) => (typeof piece === "number" ? `[${word.roles[piece]?.name ?? ""}]` : piece.trim()))
      .join(" ");
  const add = (name: string | null) => {
    const word = byName.get(name ?? "");
    if (word) onAdd(word);
    setSearch("");
  };
  return (
    <Select
      aria-label={t("addCondition")}
      placeholder={t("addCondition")}
      leftSection={<IconPlus size={14} aria-hidden />}
      data={words.map((word) => ({ value: word.name, label: spoken(word) }))}
      value={null}
      onChange={add}
      searchable
      searchValue={search}
      onSearchChange={setSearch}
      filter={({ options, search: text }) =>
        (options as ComboboxItem[]).filter(({ value, label }) =>
          matches(text, value, label, said(byName.get(value)?.help ?? "")),
        )
      }
      renderOption={({ option }) => <Offer label={option.label} word={byName.get(option.value)} />}
      maxDropdownHeight={360}
      nothingFoundMessage={t("noWord")}
    />
  );
}

function matches(wanted: string, ...texts: string[]): boolean {
  const small = wanted.trim().toLowerCase();
  return texts.some((text) => text.toLowerCase().includes(small));
}

function Offer({ label, word }: { label: string; word: ConditionWord | undefined }) {
  return (
    <Stack gap={0}>
      <span>{label}</span>
      <Text span size="xs" c="dimmed">
        {word?.name} – {said(word?.help ?? "")}
      </Text>
    </Stack>
  );
}
