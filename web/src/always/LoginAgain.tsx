import { Alert, Modal, Stack, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { KeyForm } from "./KeyForm";
import { useStopping } from "./stopping";

/** Login during work: the page with all unsaved input stays below. */
export function LoginAgain({ name }: { name: string }) {
  const { t } = useTranslation("always");
  const unsent = useStopping(({ verdict }) => verdict === "signedOut");
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
        {unsent && (
          <Alert role="alert" color="red" title={t("verdict.signedOut.title")}>
            {t("verdict.signedOut.text")}
          </Alert>
        )}
        <Text size="sm">{t("login.againText", { name })}</Text>
        <KeyForm />
      </Stack>
    </Modal>
  );
}
