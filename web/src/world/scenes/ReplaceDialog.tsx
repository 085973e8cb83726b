import { Button, Group, Modal, Stack, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { Difference } from "./Difference";

interface Props {
  name: string;
  onReplace: () => void;
  onClose: () => void;
}

/** Asks for confirmation before a saved scene is replaced; shows the differences. */
export function ReplaceDialog({ name, onReplace, onClose }: Props) {
  const { t } = useTranslation(["world", "common"]);
  return (
    <Modal opened onClose={onClose} title={t("scenes.replaceTitle", { name })} size="lg">
      <Stack>
        <Text size="sm">{t("scenes.replaceText")}</Text>
        <Difference name={name} />
        <Group justify="end">
          <Button variant="default" onClick={onClose} data-autofocus>
            {t("common:cancel")}
          </Button>
          <Button color="red" onClick={onReplace}>
            {t("scenes.replace")}
          </Button>
        </Group>
      </Stack>
    </Modal>
  );
}
