import { ActionIcon, Group, Stack, Table, Text, Tooltip } from "@mantine/core";
import { IconX } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { ElementName } from "../../widgets/ElementName";
import type { Schema } from "../../api/client";
import { useMay } from "../../api/session";
import { notifyChange } from "../../widgets/undo";
import { AddRelation } from "../edit/AddRelation";
import { transact } from "../edit/transact";
import { useWrite } from "../edit/useWrite";
import type { Tagged } from "../queries";

type Relation = Schema<"Relation">;

/** The relations of an element, in both directions. */
export function Connections({ tagged }: { tagged: Tagged }) {
  const { t } = useTranslation("world");
  const { relations, relations_total: total } = tagged.data;
  const may = useMay("write_transaction");
  return (
    <Stack gap="xs">
      <Table aria-label={t("relations.label")} verticalSpacing={2}>
        <Table.Thead>
          <Table.Tr>
            <Table.Th>{t("relations.subject")}</Table.Th>
            <Table.Th>{t("relations.relation")}</Table.Th>
            <Table.Th>{t("relations.object")}</Table.Th>
            <Table.Th w={36} aria-label={t("relations.takeBack")} />
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          {relations.map((relation) => (
            <Row key={keyOf(relation)} relation={relation} tagged={tagged} may={may} />
          ))}
        </Table.Tbody>
      </Table>
      {total > relations.length && <Text size="xs">{t("relations.more", { shown: relations.length, total })}</Text>}
      {may && !tagged.data.abstract && <AddRelation tagged={tagged} />}
    </Stack>
  );
}

function keyOf({ subject, relation, object }: Relation): string {
  return `${subject} ${relation} ${object}`;
}

function Row({ relation, tagged, may }: { relation: Relation; tagged: Tagged; may: boolean }) {
  const end = (id: string) => (id === tagged.data.id ? <Text size="sm">{id}</Text> : <ElementName id={id} />);
  return (
    <Table.Tr>
      <Table.Td>{end(relation.subject)}</Table.Td>
      <Table.Td>{relation.relation}</Table.Td>
      <Table.Td>{end(relation.object)}</Table.Td>
      <Table.Td>{may && relation.family !== "placement" && <TakeBack relation={relation} tagged={tagged} />}</Table.Td>
    </Table.Tr>
  );
}

function TakeBack({ relation, tagged }: { relation: Relation; tagged: Tagged }) {
  const { t } = useTranslation("world");
  const { subject, relation: name, object } = relation;
  const label = t("relations.takeBackOne", { relation: keyOf(relation) });
  const write = useWrite(
    () => transact(tagged.data, label, { op: "unrelate", subject, relation: name, object }),
    ({ change }) => notifyChange(t("relations.takenBack", { relation: keyOf(relation) }), change?.number),
  );
  return (
    <Group justify="end">
      <Tooltip label={label}>
        <ActionIcon aria-label={label} size="sm" loading={write.isPending} onClick={() => write.mutate()}>
          <IconX size={14} />
        </ActionIcon>
      </Tooltip>
    </Group>
  );
}
