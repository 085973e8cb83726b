import { ActionIcon, Group, Loader, Select, Tooltip } from "@mantine/core";
import { useDebouncedValue } from "@mantine/hooks";
import { IconClick } from "@tabler/icons-react";
import { useQuery } from "@tanstack/react-query";
import { useMemo, useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, api } from "../api/client";
import { keys } from "../api/keys";
import { useSelection } from "../selection/selection";

interface Props {
  label: string;
  /** Only elements of this class are offered ("sk:Container"). */
  class_: string;
  value: string | null;
  onChange: (id: string | null) => void;
  /** Offers abstract individuals and classes, too: "any starter". */
  abstract?: boolean;
  required?: boolean;
  error?: string;
}

const MANY = 200;

/** Chooses an element of a class: by name, or by a click in the 3D view or the tree. */
export function ElementPicker({ label, class_, value, onChange, abstract = false, required, error }: Props) {
  const { t } = useTranslation();
  const [search, setSearch] = useState("");
  const [asked] = useDebouncedValue(search, 150);
  const { data, isFetching } = useCandidates(class_, abstract, value !== null && asked.startsWith(value) ? "" : asked);
  const options = useMemo(() => withValue(data ?? [], value), [data, value]);
  const awaitPick = useSelection((selection) => selection.awaitPick);
  const pick = () =>
    awaitPick({ purpose: label, fits: (id) => data?.some((o) => o.value === id) ?? false, take: onChange });
  return (
    <Group gap={4} align="end" wrap="nowrap">
      <Select
        flex={1}
        label={label}
        data={options}
        value={value}
        onChange={onChange}
        searchable
        clearable={!required}
        withAsterisk={required}
        error={error}
        onSearchChange={setSearch}
        nothingFoundMessage={t("pick.empty")}
        rightSection={isFetching ? <Loader size={12} /> : undefined}
      />
      <Tooltip label={t("pick.inView")}>
        <ActionIcon aria-label={`${label}: ${t("pick.inView")}`} onClick={pick} mb={2}>
          <IconClick size={16} />
        </ActionIcon>
      </Tooltip>
    </Group>
  );
}

interface Option {
  value: string;
  label: string;
}

function useCandidates(class_: string, abstract: boolean, search: string) {
  const { t } = useTranslation();
  return useQuery({
    queryKey: keys.world("candidates", class_, abstract, search),
    queryFn: async (): Promise<Option[]> => {
      const page = await answer(
        api.GET("/api/v1/elements", { params: { query: { class: class_, text: search || undefined, limit: MANY } } }),
      );
      const there = page.items.map(({ id, label }) => ({ value: id, label: label === id ? id : `${label} (${id})` }));
      if (!abstract) return there;
      const kinds = [...new Set(page.items.map((item) => item.class))];
      const any = kinds.map((kind) => ({ value: kind, label: t("pick.any", { class: kind.replace(/^.*:/, "") }) }));
      return [...any, ...there];
    },
  });
}

function withValue(options: Option[], value: string | null): Option[] {
  if (value === null || options.some((option) => option.value === value)) return options;
  return [{ value, label: value }, ...options];
}
