import { Text } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { useMemo, useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, api } from "../api/client";
import { keys } from "../api/keys";
import { ancestors, type Classes, classesOf, EVERYTHING } from "../world/classes";
import { KindIcon } from "../world/kinds";
import { type TreeSource, VirtualTree } from "../world/tree/VirtualTree";
import { useView } from "../world/useView";
import { shownClasses } from "./search";

const NONE: Classes = new Map();
const FIRST = [EVERYTHING, "sk:SpatialThing", "sk:Object", "sk:Location"];

/** Classes below their primary parents, with their numbers of elements. */
export function ClassTree({ search }: { search: string }) {
  const { t } = useTranslation("ontology");
  const classes = useCounted();
  const [, chosen, show] = useView();
  const [open, setOpen] = useState(FIRST);
  const shown = useMemo(() => shownClasses(classes, search), [classes, search]);
  const source = useMemo(() => sourceOf(classes, shown), [classes, shown]);
  const opened = useMemo(() => (shown === null ? open : [...shown]), [shown, open]);
  const [seen, setSeen] = useState("");
  if (chosen !== seen && classes.size > 0) {
    setSeen(chosen);
    setOpen([...new Set([...open, ...ancestors(classes, chosen).slice(1)])]);
  }
  return (
    <VirtualTree
      label={t("lists.classes")}
      source={source}
      open={opened}
      onOpen={setOpen}
      selected={chosen || null}
      onChoose={(name) => show("ontology", name)}
      row={(name) => <Row name={name} classes={classes} />}
    />
  );
}

/** Counts change with the world, classes do not. */
function useCounted(): Classes {
  const { data } = useQuery({
    queryKey: keys.world("classes"),
    queryFn: () => answer(api.GET("/api/v1/ontology/classes")),
    select: classesOf,
  });
  return data ?? NONE;
}

function sourceOf(classes: Classes, shown: ReadonlySet<string> | null): TreeSource {
  const seen = (names: readonly string[]) => (shown === null ? names : names.filter((name) => shown.has(name)));
  const children = (name: string) =>
    seen(name === "" ? [...classes.keys()].slice(0, 1) : (classes.get(name)?.children ?? []));
  return { children, name: (name) => classes.get(name)?.label ?? name, folder: (name) => children(name).length > 0 };
}

function Row({ name, classes }: { name: string; classes: Classes }) {
  const info = classes.get(name);
  if (info === undefined) return null;
  return (
    <>
      <KindIcon class_={name} />
      <Text span size="sm" truncate>
        {info.label}
      </Text>
      <Text span size="xs" c="dimmed" truncate>
        {name}
      </Text>
      {info.instances > 0 && (
        <Text span size="xs" c="dimmed" ml="auto">
          {info.instances}
        </Text>
      )}
    </>
  );
}
