import { ActionIcon, Button, Group, Stack, Table, TextInput, Tooltip, VisuallyHidden } from "@mantine/core";
import { IconPlus, IconTable, IconTrash } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { CountField } from "../widgets/arguments/CountField";
import { ElementPicker } from "../widgets/ElementPicker";
import { ClassPicker } from "./ClassPicker";
import type { Filled, Piece } from "./draft";
import { usePlaces } from "./pieces";
import type { ConditionWord } from "./sentence";
import { classOf, type Content, EMPTY, type Field, fieldsOf, isCounted } from "./templates";

interface Props {
  content: Content;
  filled: Filled;
  words: readonly ConditionWord[];
  onChange: (materials: readonly Piece[]) => void;
}

const PART = "sk:Manipulatable";
const PLACE = "sk:Container";

/** The bill of parts that a template requires, one row per part. */
export function Materials({ content, filled, words, onChange }: Props) {
  const { t } = useTranslation("goal");
  const { materials } = filled;
  const fields = fieldsOf(content);
  const counted = isCounted(fields);
  const classAt = (field: Field) => classOf(content, { material: field }, words);
  const kit = Object.values(filled.parameters).find(Boolean) ?? null;
  const places = usePlaces(fields.includes("location") ? kit : null, classAt("location") ?? PLACE).data ?? [];
  const missing = places.filter(({ id }) => !materials.some(({ location }) => location === id));
  const set = (index: number, part: Partial<Piece>) =>
    onChange(materials.map((piece, at) => (at === index ? { ...piece, ...part } : piece)));
  return (
    <Stack gap="xs">
      <Table aria-label={t("materials.table")} withTableBorder verticalSpacing={4} horizontalSpacing={4}>
        <Table.Thead>
          <Table.Tr>
            {fields.map((field) => (
              <Table.Th key={field}>{t(`materials.${field}`)}</Table.Th>
            ))}
            {counted && <Table.Th w={80}>{t("materials.quantity")}</Table.Th>}
            <Table.Th w={36}>
              <VisuallyHidden>{t("materials.remove")}</VisuallyHidden>
            </Table.Th>
          </Table.Tr>
        </Table.Thead>
        <Table.Tbody>
          {materials.map((piece, index) => (
            // Rows have no identity of their own.
            <Table.Tr key={index}>
              {fields.map((field) => (
                <Table.Td key={field}>
                  <Cell
                    field={field}
                    label={t("materials.cell", { field: t(`materials.${field}`), row: index + 1 })}
                    class_={classAt(field)}
                    value={piece[field]}
                    onChange={(value) => set(index, { [field]: value })}
                  />
                </Table.Td>
              ))}
              {counted && (
                <Table.Td>
                  <CountField
                    aria-label={t("materials.cell", { field: t("materials.quantity"), row: index + 1 })}
                    min={1}
                    max={1000}
                    value={piece.quantity}
                    onChange={(quantity) => set(index, { quantity })}
                  />
                </Table.Td>
              )}
              <Table.Td>
                <Tooltip label={t("materials.remove")}>
                  <ActionIcon
                    color="red"
                    aria-label={`${t("materials.remove")}: ${index + 1}`}
                    onClick={() => onChange(materials.filter((_, at) => at !== index))}
                  >
                    <IconTrash size={16} aria-hidden />
                  </ActionIcon>
                </Tooltip>
              </Table.Td>
            </Table.Tr>
          ))}
        </Table.Tbody>
      </Table>
      <Group gap="xs">
        <Button
          variant="default"
          leftSection={<IconPlus size={14} aria-hidden />}
          onClick={() => onChange([...materials, EMPTY])}
        >
          {t("materials.add")}
        </Button>
        {missing.length > 0 && (
          <Button
            variant="default"
            leftSection={<IconTable size={14} aria-hidden />}
            onClick={() => onChange([...materials, ...missing.map(({ id }) => ({ ...EMPTY, location: id }))])}
          >
            {t("materials.addPlaces", { count: missing.length })}
          </Button>
        )}
      </Group>
    </Stack>
  );
}

interface CellProps {
  field: Field;
  label: string;
  class_: string | undefined;
  value: string;
  onChange: (value: string) => void;
}

function Cell({ field, label, class_, value, onChange }: CellProps) {
  if (field === "class") return <ClassPicker label={label} class_={class_ ?? PART} value={value} onChange={onChange} />;
  if (field === "location" || field === "id") {
    return (
      <ElementPicker
        label={label}
        hideLabel
        class_={class_ ?? (field === "id" ? PART : PLACE)}
        value={value || null}
        onChange={(id) => onChange(id ?? "")}
      />
    );
  }
  return <TextInput aria-label={label} value={value} onChange={(event) => onChange(event.currentTarget.value)} />;
}
