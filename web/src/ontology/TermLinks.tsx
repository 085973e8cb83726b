import { Anchor, Group, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { useView } from "../world/useView";

/** Names of the ontology as links to their descriptions. */
export function TermLinks({ names }: { names: readonly string[] }) {
  const { t } = useTranslation();
  const [, , show] = useView();
  if (names.length === 0) {
    return (
      <Text span size="sm" c="dimmed">
        {t("none")}
      </Text>
    );
  }
  return (
    <Group gap="xs" component="span">
      {names.map((name) => (
        <Anchor key={name} component="button" type="button" size="sm" onClick={() => show("ontology", name)}>
          {name}
        </Anchor>
      ))}
    </Group>
  );
}
