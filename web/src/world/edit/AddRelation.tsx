import { Button, Fieldset, Group, SegmentedControl, Select, Stack, Text } from "@mantine/core";
import { useMemo, useState } from "react";
import { useTranslation } from "react-i18next";
import { said } from "../../i18n/sentences";
import { ElementPicker } from "../../widgets/ElementPicker";
import { MayButton } from "../../widgets/MayButton";
import { notifyChange } from "../../widgets/undo";
import { useClasses } from "../classes";
import { type RelationInfo, type Tagged, useRelations } from "../queries";
import { fitsEnd } from "./placements";
import { transact } from "./transact";
import { useWrite } from "./useWrite";

type Direction = "from" | "to";

/** Adds a relation between elements: those that the ontology permits, in either direction. */
export function AddRelation({ tagged }: { tagged: Tagged }) {
  const { t } = useTranslation(["world", "common"]);
  const [open, setOpen] = useState(false);
  if (!open) {
    return (
      <Group>
        <Button variant="default" onClick={() => setOpen(true)}>
          {t("relations.add")}
        </Button>
      </Group>
    );
  }
  return <NewRelation tagged={tagged} onDone={() => setOpen(false)} />;
}

function NewRelation({ tagged, onDone }: { tagged: Tagged; onDone: () => void }) {
  const { t } = useTranslation(["world", "common"]);
  const [direction, setDirection] = useState<Direction>("from");
  const [name, setName] = useState<string | null>(null);
  const [other, setOther] = useState<string | null>(null);
  const options = useAllowed(tagged.data.class, direction);
  const relation = options.find((one) => one.name === name);
  const write = useWrite(
    () => state(tagged, direction, name ?? "", other ?? ""),
    ({ change }) => {
      notifyChange(t("relations.added", { relation: change ? said(change.reason) : relation?.label }), change?.number);
      onDone();
    },
  );
  return (
    <Fieldset legend={t("relations.add")} p="xs">
      <Stack gap={6}>
        <SegmentedControl
          size="xs"
          aria-label={t("relations.direction")}
          value={direction}
          onChange={(value) => setDirection(value as Direction)}
          data={[
            { value: "from", label: t("relations.from", { id: tagged.data.id }) },
            { value: "to", label: t("relations.to", { id: tagged.data.id }) },
          ]}
        />
        <Select
          label={t("relations.relation")}
          data={options.map((one) => ({ value: one.name, label: `${one.label} (${one.name})` }))}
          searchable
          value={relation?.name ?? null}
          onChange={setName}
        />
        {relation && (
          <>
            <Text size="xs" c="dimmed">
              {relation.comment}
            </Text>
            <ElementPicker
              label={direction === "from" ? t("relations.object") : t("relations.subject")}
              class_={farEnd(relation, direction)[0]?.[0] ?? "sk:Element"}
              value={other}
              onChange={setOther}
            />
          </>
        )}
        <Group justify="end">
          <Button variant="default" onClick={onDone}>
            {t("common:cancel")}
          </Button>
          <MayButton
            operation="write_transaction"
            disabled={relation === undefined || other === null}
            loading={write.isPending}
            onClick={() => write.mutate()}
          >
            {t("common:add")}
          </MayButton>
        </Group>
      </Stack>
    </Fieldset>
  );
}

function farEnd(relation: RelationInfo, direction: Direction) {
  return direction === "from" ? relation.objects : relation.subjects;
}

function useAllowed(class_: string, direction: Direction): RelationInfo[] {
  const classes = useClasses();
  const { data } = useRelations();
  return useMemo(() => {
    const stated = (data ?? []).filter(
      (one) => !one.computed && one.family !== "placement" && one.family !== "computed",
    );
    return stated.filter((one) => fitsEnd(classes, class_, direction === "from" ? one.subjects : one.objects));
  }, [classes, data, class_, direction]);
}

function state({ data }: Tagged, direction: Direction, relation: string, other: string) {
  const [subject, object] = direction === "from" ? [data.id, other] : [other, data.id];
  return transact(data, `${subject} ${relation} ${object}`, { op: "relate", subject, relation, object });
}
