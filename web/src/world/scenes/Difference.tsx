import { Code, Loader, Stack, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { problemText } from "../../widgets/problems";
import { useDifference } from "./queries";

/** The differences that make the current scene of another one, as lines. */
export function Difference({ name }: { name: string }) {
  const { t } = useTranslation("world");
  const { data, error } = useDifference(name, true);
  if (error) return <Text size="sm">{problemText(error)}</Text>;
  if (data === undefined) return <Loader size="xs" aria-label={t("scenes.comparing")} />;
  if (data.total === 0) return <Text size="sm">{t("scenes.same", { name })}</Text>;
  return (
    <Stack gap={4}>
      <Text size="xs">{t("scenes.legend")}</Text>
      <Code
        block
        mah={260}
        style={{ whiteSpace: "pre-wrap" }}
        aria-label={t("scenes.difference", { name })}
        tabIndex={0}
      >
        {data.lines.join("\n")}
      </Code>
      {data.total > data.lines.length && (
        <Text size="xs">{t("scenes.moreLines", { count: data.total - data.lines.length })}</Text>
      )}
    </Stack>
  );
}
