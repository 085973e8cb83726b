import { Alert, Group, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { Moment } from "../../widgets/Moment";
import { said } from "../../i18n/sentences";
import { UndoButton } from "../changes/UndoButton";
import { useRemoval } from "./removal";

/** Shows who removed an element that existed before, and how to restore it. */
export function Gone({ id }: { id: string }) {
  const { t } = useTranslation("world");
  const { data: removal } = useRemoval(id);
  if (removal === undefined) return null;
  return (
    <Alert color="orange" title={t("gone.title", { id })}>
      {removal && (
        <Group justify="space-between" gap="xs">
          <Text size="sm">
            {t("gone.by", { ...removal, reason: said(removal.reason) })} <Moment at={removal.written} />
          </Text>
          <UndoButton only={removal.number} />
        </Group>
      )}
    </Alert>
  );
}
