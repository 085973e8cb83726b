import { Alert, Button, Center, Group, Loader, Stack, Title } from "@mantine/core";
import { IconPlugConnectedX } from "@tabler/icons-react";
import { useEffect } from "react";
import { useTranslation } from "react-i18next";
import { useMe } from "../api/session";
import { problemText } from "../widgets/problems";

const AGAIN = 1500; // ms

/** Reports that the server does not answer, and retries until it does. */
export function Unreachable({ error }: { error: Error }) {
  const { t } = useTranslation("always");
  const { refetch } = useMe();
  useEffect(() => {
    const timer = setInterval(() => void refetch(), AGAIN);
    return () => clearInterval(timer);
  }, [refetch]);
  return (
    <Center component="main" h="100%" p="md">
      <Stack maw={480}>
        <Title order={1} size="h3">
          skiros
        </Title>
        <Alert role="alert" color="orange" icon={<IconPlugConnectedX aria-hidden />} title={t("unreachable.title")}>
          {problemText(error)} {t("unreachable.text")}
        </Alert>
        <Group>
          <Loader size="xs" aria-hidden />
          <Button variant="default" onClick={() => void refetch()}>
            {t("unreachable.again")}
          </Button>
        </Group>
      </Stack>
    </Center>
  );
}
