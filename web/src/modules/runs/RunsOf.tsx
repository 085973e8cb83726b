import { Button, Group, Paper, Stack, Title } from "@mantine/core";
import { useTranslation } from "react-i18next";
import type { View } from "../places";
import { useRuns } from "../queries";
import { RunView } from "./RunView";

interface Props {
  agent: string;
  module: string;
  show: (view: View, ...rest: string[]) => void;
}

/** The last run of a module, and a link to earlier ones. */
export function RunsOf({ agent, module, show }: Props) {
  const { t } = useTranslation("modules");
  const { data: runs = [] } = useRuns();
  const own = runs.filter((run) => run.module === module && run.agent === agent);
  const [last] = own;
  if (last === undefined) return null;
  return (
    <Paper withBorder p="sm" component="section" aria-label={t("run.last")}>
      <Stack gap="xs">
        <Group justify="space-between">
          <Title order={3} size="h6">
            {t("run.last")}
          </Title>
          <Button variant="subtle" size="compact-xs" onClick={() => show("runs", last.id)}>
            {t("run.all", { count: own.length })}
          </Button>
        </Group>
        <RunView id={last.id} />
      </Stack>
    </Paper>
  );
}
