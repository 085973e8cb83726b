import { Stack, Text } from "@mantine/core";
import { useMemo } from "react";
import { useTranslation } from "react-i18next";
import type { Schema } from "../api/client";
import { Graph } from "../widgets/Graph";
import { useClasses } from "../world/classes";
import { type RelationInfo, useRelations } from "../world/queries";
import { useView } from "../world/useView";
import { neighbours } from "./neighbours";

const NONE: RelationInfo[] = [];

/** A class between its parents, its subclasses, and the classes of its relations. */
export default function NeighbourGraph({ class_ }: { class_: Schema<"ClassDetails"> }) {
  const { t } = useTranslation("ontology");
  const [, , show] = useView();
  const classes = useClasses();
  const relations = useRelations().data ?? NONE;
  const { nodes, edges, left } = useMemo(() => neighbours(class_, classes, relations), [class_, classes, relations]);
  return (
    <Stack gap={4}>
      <div style={{ height: 360 }}>
        <Graph
          label={t("class.graph")}
          nodes={nodes}
          edges={edges}
          direction="right"
          chosen={class_.name}
          onChoose={(name) => name !== class_.name && classes.has(name) && show("ontology", name)}
        />
      </div>
      {left > 0 && <Text size="xs">{t("class.left", { count: left })}</Text>}
    </Stack>
  );
}
