import { Group, Paper, Stack, Text } from "@mantine/core";
import { notifications } from "@mantine/notifications";
import { IconPlayerPlay, IconRefresh } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { answer, api } from "../../api/client";
import { keys } from "../../api/keys";
import { useSingleMutation } from "../../api/mutations";
import { queryClient } from "../../api/queries";
import { useStation } from "../../live/station";
import { CountField } from "../../widgets/arguments/CountField";
import { MayButton } from "../../widgets/MayButton";
import { notifyProblem } from "../../widgets/problems";
import type { Draft } from "../drafts";
import { useRuns } from "../queries";
import { isOver } from "../runs/states";
import { CopyAs } from "./CopyAs";

interface Props {
  agent: string;
  module: string;
  draft: Draft;
  change: (change: Partial<Draft>) => void;
  /** Whether the arguments are valid. */
  sound: boolean;
}

const MOST = 1000;

/** Runs a module once or N times, and resets it after a fault. */
export function RunBar({ agent, module, draft, change, sound }: Props) {
  const { t } = useTranslation("modules");
  const path = { agent, module };
  const halted = useStation(({ state }) => Boolean(state?.halted));
  const { data: runs = [] } = useRuns();
  const atWork = runs.some((one) => one.agent === agent && one.module === module && !isOver(one));
  const run = useSingleMutation({
    mutationFn: () =>
      answer(
        api.POST("/api/v1/modules/{agent}/{module}/runs", {
          params: { path },
          body: { arguments: draft.values, repeat: draft.repeat },
        }),
      ),
    // Pending until the run is fetched, so that the button cannot be pressed twice.
    onSuccess: () => queryClient.invalidateQueries({ queryKey: keys.moduleRuns() }),
    onError: notifyProblem,
  });
  const reset = useSingleMutation({
    mutationFn: () => answer(api.POST("/api/v1/modules/{agent}/{module}/reset", { params: { path } })),
    onSuccess: () => notifications.show({ message: t("run.wasReset", { module }) }),
    onError: notifyProblem,
  });
  return (
    <Paper withBorder p="sm" component="section" aria-label={t("run.label")}>
      <Stack gap={4}>
        <Group align="end" gap="xs">
          <CountField
            label={t("run.repeat")}
            w="6rem"
            min={1}
            max={MOST}
            value={draft.repeat}
            onChange={(repeat) => change({ repeat })}
          />
          <MayButton
            operation="run_module"
            leftSection={<IconPlayerPlay size={14} aria-hidden />}
            loading={run.isPending}
            disabled={!sound || halted || atWork}
            onClick={() => run.mutate()}
          >
            {draft.repeat > 1 ? t("run.runMany", { count: draft.repeat }) : t("run.run")}
          </MayButton>
          <MayButton
            operation="reset_module"
            variant="default"
            leftSection={<IconRefresh size={14} aria-hidden />}
            loading={reset.isPending}
            onClick={() => reset.mutate()}
          >
            {t("run.reset")}
          </MayButton>
          <CopyAs wanted={{ agent, module, values: draft.values, repeat: draft.repeat }} />
        </Group>
        {!sound && <Text size="xs">{t("run.faulty")}</Text>}
        {halted && <Text size="xs">{t("run.halted")}</Text>}
      </Stack>
    </Paper>
  );
}
