import { Group, Select, TextInput } from "@mantine/core";
import { IconSearch } from "@tabler/icons-react";
import { useMemo } from "react";
import { useTranslation } from "react-i18next";
import { useClasses } from "../classes";

/** The search: a text in id, label or class, and a class. */
export interface Search {
  text: string;
  class_: string | null;
}

interface Props {
  search: Search;
  onChange: (search: Search) => void;
}

export function TreeSearch({ search, onChange }: Props) {
  const { t } = useTranslation("world");
  const classes = useClasses();
  const options = useMemo(
    () => [...classes.values()].filter((one) => one.instances > 0).map(({ name, label }) => ({ value: name, label })),
    [classes],
  );
  return (
    <Group gap={6} wrap="nowrap">
      <TextInput
        flex={1}
        type="search"
        aria-label={t("search.text")}
        placeholder={t("search.text")}
        leftSection={<IconSearch size={14} aria-hidden />}
        value={search.text}
        onChange={(event) => onChange({ ...search, text: event.currentTarget.value })}
      />
      <Select
        w={150}
        aria-label={t("search.class")}
        placeholder={t("search.class")}
        data={options}
        searchable
        clearable
        value={search.class_}
        onChange={(class_) => onChange({ ...search, class_ })}
      />
    </Group>
  );
}
