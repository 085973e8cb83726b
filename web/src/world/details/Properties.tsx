import { Badge, Group, Table, Text, Tooltip } from "@mantine/core";
import { IconBooks, IconSchool, IconUser, type TablerIcon } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { ElementName } from "../../widgets/ElementName";
import type { Schema } from "../../api/client";
import { type Details, type PropertyInfo, useClass } from "../queries";
import { useWords } from "../useWords";
import { written } from "../values";

type Property = Schema<"Property">;
type Origin = Property["origin"];

const ICONS: Record<Origin, TablerIcon> = { own: IconUser, taught: IconSchool, class: IconBooks };
const LONG = 120; // characters

/** The values of an element with their origins. */
export function Properties({ element }: { element: Details }) {
  const { t } = useTranslation("world");
  const { data } = useClass(element.class);
  const entries = Object.entries(element.properties);
  if (entries.length === 0) return <Text size="sm">{t("properties.none")}</Text>;
  return (
    <Table aria-label={t("properties.label")} verticalSpacing={3} layout="fixed">
      <Table.Thead>
        <Table.Tr>
          <Table.Th w="34%">{t("properties.name")}</Table.Th>
          <Table.Th>{t("properties.value")}</Table.Th>
          <Table.Th w={112}>{t("properties.origin")}</Table.Th>
        </Table.Tr>
      </Table.Thead>
      <Table.Tbody>
        {entries.map(([name, property]) => (
          <Row
            key={name}
            name={name}
            property={property}
            info={data?.properties.find((known) => known.name === name)}
          />
        ))}
      </Table.Tbody>
    </Table>
  );
}

interface RowProps {
  name: string;
  property: Property;
  info: PropertyInfo | undefined;
}

function Row({ name, property, info }: RowProps) {
  return (
    <Table.Tr>
      <Table.Th fw={500} scope="row">
        <Tooltip label={info?.comment ?? name} multiline maw={320}>
          <Text span size="sm" tabIndex={0} style={{ overflowWrap: "anywhere" }}>
            {info?.label ?? name}
          </Text>
        </Tooltip>
      </Table.Th>
      <Table.Td style={{ overflowWrap: "anywhere" }}>
        <Value value={property.value} unit={info?.unit ?? ""} />
      </Table.Td>
      <Table.Td>
        <OriginMark property={property} />
      </Table.Td>
    </Table.Tr>
  );
}

function Value({ value, unit }: { value: unknown; unit: string }) {
  const words = useWords();
  const text = written(value, words);
  if (text.length > LONG) {
    return (
      <details>
        <summary>{text.slice(0, LONG / 2).replace(/\s+/g, " ")} …</summary>
        <pre style={{ whiteSpace: "pre-wrap", fontSize: "0.75rem", margin: 0 }}>{text}</pre>
      </details>
    );
  }
  return (
    <Text span size="sm">
      {text}
      {typeof value === "number" && unit && ` ${unit}`}
    </Text>
  );
}

/** The origin of a value, as an icon and text. */
function OriginMark({ property: { origin, taught_by } }: { property: Property }) {
  const { t } = useTranslation("world");
  const Icon = ICONS[origin];
  return (
    <Group gap={4}>
      <Tooltip label={t(`properties.originHelp.${origin}`)}>
        <Badge
          variant={origin === "own" ? "light" : "default"}
          tt="none"
          fw={500}
          leftSection={<Icon size={11} aria-hidden />}
        >
          {t(`properties.originName.${origin}`)}
        </Badge>
      </Tooltip>
      {taught_by && <ElementName id={taught_by} />}
    </Group>
  );
}
