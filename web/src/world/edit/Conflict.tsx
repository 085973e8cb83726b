import { Button, Group, Modal, Stack, Table, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { Status } from "../../widgets/Status";
import { type Tagged, useClass } from "../queries";
import { useWords } from "../useWords";
import { written } from "../values";
import { type Difference, differences, draftOf, LABEL, PLACEMENT } from "./draft";
import type { Editing } from "./useEditing";

interface Props {
  editing: Editing;
  theirs: Tagged;
  onDone: () => void;
}

/** Another person has changed the element meanwhile: shows both versions and asks what to do. */
export function Conflict({ editing, theirs, onDone }: Props) {
  const { t } = useTranslation("world");
  const found = differences(editing.before, draftOf(theirs.data), editing.draft);
  return (
    <Modal opened onClose={editing.goOn} title={t("conflict.title")} size="lg">
      <Stack>
        <Text size="sm">{t("conflict.text", { label: theirs.data.id, version: theirs.data.version })}</Text>
        <Comparison found={found} class_={theirs.data.class} />
        <Group justify="end">
          <Button variant="default" onClick={editing.goOn}>
            {t("conflict.goOn")}
          </Button>
          <Button variant="default" onClick={onDone}>
            {t("conflict.theirs")}
          </Button>
          <Button onClick={editing.saveOnTop}>{t("conflict.mine")}</Button>
        </Group>
      </Stack>
    </Modal>
  );
}

interface ComparisonProps {
  found: readonly Difference[];
  class_: string;
}

function Comparison({ found, class_ }: ComparisonProps) {
  const { t } = useTranslation("world");
  const { data } = useClass(class_);
  const labels = new Map(data?.properties.map(({ name, label }) => [name, label]));
  labels.set(LABEL, t("edit.name")).set(PLACEMENT, t("edit.placement"));
  return (
    <Table aria-label={t("conflict.table")} verticalSpacing={4}>
      <Table.Thead>
        <Table.Tr>
          <Table.Th>{t("conflict.field")}</Table.Th>
          <Table.Th>{t("conflict.was")}</Table.Th>
          <Table.Th>{t("conflict.isNow")}</Table.Th>
          <Table.Th>{t("conflict.wanted")}</Table.Th>
          <Table.Th />
        </Table.Tr>
      </Table.Thead>
      <Table.Tbody>
        {found.map((one) => (
          <Line key={one.field} name={labels.get(one.field) ?? one.field} one={one} />
        ))}
      </Table.Tbody>
    </Table>
  );
}

function Line({ name, one }: { name: string; one: Difference }) {
  const { t } = useTranslation("world");
  const words = useWords();
  return (
    <Table.Tr>
      <Table.Th scope="row">{name}</Table.Th>
      <Table.Td>{written(one.was, words)}</Table.Td>
      <Table.Td>{written(one.theirs, words)}</Table.Td>
      <Table.Td>{one.byMe ? written(one.mine, words) : t("conflict.left")}</Table.Td>
      <Table.Td style={{ whiteSpace: "nowrap" }}>
        {one.clash && <Status mood="warning" text={t("conflict.clash")} />}
      </Table.Td>
    </Table.Tr>
  );
}
