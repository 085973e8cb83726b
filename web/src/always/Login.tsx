import { Center, Group, Paper, Stack, Text, Title } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { KeyForm } from "./KeyForm";
import { LanguageButton, SchemeButton } from "./Preferences";

/** Asks for an API key. */
export function Login() {
  const { t } = useTranslation("always");
  return (
    <Center component="main" h="100%" p="md">
      <Paper withBorder p="lg" w={400}>
        <Stack>
          <Group justify="space-between">
            <Title order={1} size="h3">
              skiros
            </Title>
            <Group gap={4}>
              <LanguageButton />
              <SchemeButton />
            </Group>
          </Group>
          <Text size="sm">{t("login.text")}</Text>
          <KeyForm />
        </Stack>
      </Paper>
    </Center>
  );
}
