import { Text } from "@mantine/core";
import { keepPreviousData, useQuery } from "@tanstack/react-query";
import { useMemo } from "react";
import { useTranslation } from "react-i18next";
import { answer, api, type Schema } from "../../api/client";
import { keys } from "../../api/keys";
import { useSelection } from "../../selection/selection";
import { byName, nameOf, spoken } from "../../widgets/names";
import { KindIcon } from "../kinds";
import classes from "./SceneTree.module.css";
import type { Search } from "./TreeSearch";
import { type TreeSource, VirtualTree } from "./VirtualTree";

type Summary = Schema<"ElementSummary">;

const MOST = 500;

/** The results of a search as a flat list, each with its place. */
export function Found({ search }: { search: Search }) {
  const { t } = useTranslation("world");
  const { data } = useFound(search);
  const selected = useSelection((selection) => selection.selected);
  const choose = useSelection((selection) => selection.choose);
  const hover = useSelection((selection) => selection.hover);
  const items = useMemo(() => new Map(data?.items.map((item) => [item.id, item])), [data]);
  const source = useMemo(() => flat(items), [items]);
  if (data !== undefined && items.size === 0) {
    return (
      <Text size="sm" c="dimmed" p="xs" role="status">
        {t("search.nothing")}
      </Text>
    );
  }
  return (
    <VirtualTree
      label={t("search.found", { count: items.size, more: data?.next ? "+" : "" })}
      source={source}
      open={NONE}
      onOpen={ignore}
      selected={selected}
      onChoose={choose}
      onHover={hover}
      row={(id) => <Hit item={items.get(id)} />}
    />
  );
}

const NONE: string[] = [];
const ignore = () => undefined;

function flat(items: ReadonlyMap<string, Summary>): TreeSource {
  const ids = [...items.keys()].sort(byName);
  return {
    children: (id) => (id === "" ? ids : []),
    name: (id) => nameOf(id, items.get(id)?.label ?? id),
    folder: () => false,
  };
}

function useFound({ text, class_ }: Search) {
  return useQuery({
    queryKey: keys.world("found", text, class_),
    queryFn: () =>
      answer(
        api.GET("/api/v1/elements", {
          params: { query: { text: text || undefined, class: class_ ?? undefined, limit: MOST } },
        }),
      ),
    placeholderData: keepPreviousData,
  });
}

function Hit({ item }: { item: Summary | undefined }) {
  if (item === undefined) return null;
  return (
    <>
      <KindIcon class_={item.class} />
      <Text span size="sm" truncate>
        {item.label}
      </Text>
      <Text span size="xs" c="dimmed" truncate>
        {item.id}
      </Text>
      {item.placement && (
        <Text span size="xs" c="dimmed" className={classes.relation}>
          {spoken(item.placement.relation)} {item.placement.place}
        </Text>
      )}
    </>
  );
}
