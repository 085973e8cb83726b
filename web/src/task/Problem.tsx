import { Alert, Button, Group, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { problemText } from "../widgets/problems";

/** A failed request, with a button to retry. */
export function Problem({ error, again }: { error: unknown; again?: () => unknown }) {
  const { t } = useTranslation();
  return (
    <Alert color="red" p="xs" role="alert">
      <Group gap="xs" justify="space-between">
        <Text size="sm">{problemText(error)}</Text>
        {again !== undefined && (
          <Button variant="light" color="red" onClick={() => void again()}>
            {t("retry")}
          </Button>
        )}
      </Group>
    </Alert>
  );
}
