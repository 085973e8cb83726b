import { Modal, Stack, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { KeyForm } from "./KeyForm";

/** A login ended in the midst of work: the page stays below, with everything that was not saved. */
export function LoginAgain({ name }: { name: string }) {
  const { t } = useTranslation("always");
  return (
    <Modal
      opened
      onClose={() => undefined}
      withCloseButton={false}
      closeOnEscape={false}
      closeOnClickOutside={false}
      title={t("login.again")}
      centered
    >
      <Stack>
        <Text size="sm">{t("login.againText", { name })}</Text>
        <KeyForm />
      </Stack>
    </Modal>
  );
}
