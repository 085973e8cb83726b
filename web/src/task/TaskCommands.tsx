import { Group } from "@mantine/core";
import { IconPlayerPause, IconPlayerPlay, IconPlayerStop, IconPlayerTrackNext } from "@tabler/icons-react";
import { useQueryClient } from "@tanstack/react-query";
import { useTranslation } from "react-i18next";
import { answer, api, type Schema } from "../api/client";
import { keys } from "../api/keys";
import { useSingleMutation } from "../api/mutations";
import { MayButton } from "../widgets/MayButton";
import { notifyProblem } from "../widgets/problems";
import { useStation } from "../live/station";

const ICONS = {
  pause: IconPlayerPause,
  resume: IconPlayerPlay,
  step: IconPlayerTrackNext,
  stop: IconPlayerStop,
};
type Command = keyof typeof ICONS;

/** Pauses, resumes, steps or stops a task that belongs to no job. */
export function TaskCommands({ task }: { task: Schema<"TaskInfo"> }) {
  const { t } = useTranslation("task");
  const halted = useStation(({ state }) => Boolean(state?.halted));
  const client = useQueryClient();
  const { mutate, isPending } = useSingleMutation({
    mutationFn: (command: Command) =>
      answer(api.POST("/api/v1/tasks/{name}/{command}", { params: { path: { name: task.name, command } } })),
    onError: notifyProblem,
    onSettled: () => client.invalidateQueries({ queryKey: keys.tasks() }),
  });
  return (
    <Group gap={6} role="group" aria-label={t("commands.label")}>
      {commandsOf(task).map((command) => {
        const Icon = ICONS[command];
        return (
          <MayButton
            key={command}
            operation="command_task"
            variant="default"
            disabled={isPending || (halted && (command === "resume" || command === "step"))}
            leftSection={<Icon size={14} aria-hidden />}
            onClick={() => mutate(command)}
          >
            {t(`taskCommands.${command}`)}
          </MayButton>
        );
      })}
    </Group>
  );
}

function commandsOf({ status, job }: Schema<"TaskInfo">): readonly Command[] {
  if (status === "ended" || job !== "") return [];
  return status === "paused" ? ["resume", "step", "stop"] : ["pause", "step", "stop"];
}
