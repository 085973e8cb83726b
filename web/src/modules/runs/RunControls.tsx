import { Group } from "@mantine/core";
import { IconHandStop, IconPlayerPause, IconPlayerPlay, IconPlayerTrackNext } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { answer, api } from "../../api/client";
import { keys } from "../../api/keys";
import { useSingleMutation } from "../../api/mutations";
import { queryClient } from "../../api/queries";
import { MayButton } from "../../widgets/MayButton";
import { notifyProblem } from "../../widgets/problems";
import type { Run } from "../queries";
import { isOver } from "./states";
import { useStation } from "../../live/station";

type Command = "pause" | "resume" | "step" | "stop";

const ICONS = {
  pause: IconPlayerPause,
  resume: IconPlayerPlay,
  step: IconPlayerTrackNext,
  stop: IconHandStop,
} as const;

/** Pause, resume, step by one control cycle, stop. */
export function RunControls({ run }: { run: Run }) {
  const { t } = useTranslation("modules");
  const command = useSingleMutation({
    mutationFn: (verb: Command) =>
      answer(api.POST("/api/v1/module-runs/{id}/{command}", { params: { path: { id: run.id, command: verb } } })),
    onSuccess: () => void queryClient.invalidateQueries({ queryKey: keys.moduleRuns() }),
    onError: notifyProblem,
  });
  const halted = useStation(({ state }) => Boolean(state?.halted));
  if (isOver(run)) return null;
  const able: Record<Command, boolean> = {
    pause: run.status === "running",
    resume: run.status === "paused" && !halted,
    step: run.status === "paused" && !halted,
    stop: run.status !== "stopping",
  };
  return (
    <Group gap="xs" role="group" aria-label={t("run.controls", { module: run.module })}>
      {(Object.keys(ICONS) as Command[]).map((verb) => {
        const Icon = ICONS[verb];
        return (
          <MayButton
            key={verb}
            operation="command_module_run"
            variant={verb === "stop" ? "filled" : "default"}
            color={verb === "stop" ? "red" : undefined}
            leftSection={<Icon size={14} aria-hidden />}
            disabled={!able[verb] || command.isPending}
            onClick={() => command.mutate(verb)}
          >
            {t(`run.${verb}`)}
          </MayButton>
        );
      })}
    </Group>
  );
}
