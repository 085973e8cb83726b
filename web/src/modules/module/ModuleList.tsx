import { NavLink, SegmentedControl, Select, Stack, Text, TextInput } from "@mantine/core";
import { IconBolt, IconPuzzle, IconSearch } from "@tabler/icons-react";
import { useMemo, useState } from "react";
import { useTranslation } from "react-i18next";
import { said } from "../../i18n/sentences";
import { EVERYTHING, type Filter, fitting } from "../filter";
import type { Summary } from "../queries";

interface Props {
  modules: readonly Summary[];
  chosen: string | undefined;
  choose: (module: string, agent: string) => void;
}

export function ModuleList({ modules, chosen, choose }: Props) {
  const { t } = useTranslation("modules");
  const [filter, setFilter] = useState<Filter>(EVERYTHING);
  const shown = useMemo(() => fitting(modules, filter), [modules, filter]);
  return (
    <Stack gap="xs">
      <Filters modules={modules} filter={filter} change={(part) => setFilter({ ...filter, ...part })} />
      <Text size="xs" c="dimmed" role="status">
        {modules.length > 0 && t("list.count", { shown: shown.length, all: modules.length })}
      </Text>
      <div>
        {shown.map((module) => (
          <Entry
            key={module.name}
            module={module}
            active={module.name === chosen}
            choose={() => choose(module.name, doerOf(module, filter.robot))}
          />
        ))}
      </div>
    </Stack>
  );
}

function doerOf({ agents }: Summary, robot: string): string {
  return (agents.find((place) => place.robot === robot) ?? agents[0])?.agent ?? "";
}

function Entry({ module, active, choose }: { module: Summary; active: boolean; choose: () => void }) {
  const { t } = useTranslation("modules");
  const Icon = module.kind === "skill" ? IconPuzzle : IconBolt;
  return (
    <NavLink
      component="button"
      active={active}
      aria-current={active ? "true" : undefined}
      onClick={choose}
      label={module.name}
      description={`${t(`kind.${module.kind}`)} · ${said(module.help)}`}
      leftSection={<Icon size={16} aria-hidden />}
    />
  );
}

interface FiltersProps {
  modules: readonly Summary[];
  filter: Filter;
  change: (part: Partial<Filter>) => void;
}

function Filters({ modules, filter, change }: FiltersProps) {
  const { t } = useTranslation("modules");
  const robots = [...new Set(modules.flatMap((module) => module.agents.map((place) => place.robot)))].filter(Boolean);
  return (
    <>
      <TextInput
        aria-label={t("list.search")}
        placeholder={t("list.search")}
        leftSection={<IconSearch size={14} aria-hidden />}
        value={filter.text}
        onChange={(event) => change({ text: event.currentTarget.value })}
      />
      <SegmentedControl
        size="xs"
        fullWidth
        aria-label={t("list.kind")}
        data={[
          { value: "all", label: t("list.all") },
          { value: "skill", label: t("list.skills") },
          { value: "primitive", label: t("list.primitives") },
        ]}
        value={filter.kind}
        onChange={(kind) => change({ kind: kind as Filter["kind"] })}
      />
      {robots.length > 1 && (
        <Select
          aria-label={t("robot")}
          placeholder={t("list.allRobots")}
          clearable
          data={robots}
          value={filter.robot || null}
          onChange={(robot) => change({ robot: robot ?? "" })}
        />
      )}
    </>
  );
}
