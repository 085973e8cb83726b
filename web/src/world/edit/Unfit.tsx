import { Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { useClass } from "../queries";

/** Explains why the form cannot be saved yet: fields with missing or malformed numbers. */
export function Unfit({ fields, class_ }: { fields: readonly string[]; class_: string | null }) {
  const { t } = useTranslation("world");
  const { data } = useClass(class_);
  if (fields.length === 0) return null;
  const names = fields.map((field) => data?.properties.find(({ name }) => name === field)?.label ?? field);
  return (
    <Text size="xs" c="red" role="status" flex={1}>
      {t("edit.unfit", { fields: names.join(", ") })}
    </Text>
  );
}
