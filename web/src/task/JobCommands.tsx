import { Button, Group, Modal, Stack, Text, TextInput } from "@mantine/core";
import {
  IconPlayerPause,
  IconPlayerPlay,
  IconPlayerStop,
  IconTrash,
  IconX,
  IconLock,
  type TablerIcon,
} from "@tabler/icons-react";
import { useQueryClient } from "@tanstack/react-query";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, api, type Schema } from "../api/client";
import { keys } from "../api/keys";
import { useSingleMutation } from "../api/mutations";
import type { Operation } from "../api/session";
import { useStation } from "../live/station";
import { MayButton } from "../widgets/MayButton";
import { notifyProblem } from "../widgets/problems";

const GRAVE = ["stop", "abort", "cancel", "clear"] as const;
/** Commands that end a job and cannot be undone. */
type Grave = (typeof GRAVE)[number];

const COMMANDS = {
  start: { operation: "start_job", icon: IconPlayerPlay },
  "revoke-start": { operation: "revoke_start_of_job", icon: IconLock },
  pause: { operation: "pause_job", icon: IconPlayerPause },
  resume: { operation: "resume_job", icon: IconPlayerPlay },
  stop: { operation: "stop_job", icon: IconPlayerStop },
  abort: { operation: "abort_job", icon: IconX },
  cancel: { operation: "cancel_job", icon: IconX },
  clear: { operation: "clear_job", icon: IconTrash },
} satisfies Record<string, { operation: Operation; icon: TablerIcon }>;

type Command = keyof typeof COMMANDS;

function isCommand(name: string): name is Command {
  return Object.hasOwn(COMMANDS, name);
}

interface Props {
  job: Schema<"Job">;
  /** Called after the job was removed. */
  gone?: () => void;
  /** The selected one; all if undefined. */
  only?: Command;
}

/** The commands for a job in its current state; those that end it need confirmation. */
export function JobCommands({ job, gone = () => undefined, only }: Props) {
  const { t } = useTranslation("task");
  const [asking, ask] = useState<Grave | null>(null);
  const command = useCommand(job, gone);
  const halted = useStation(({ state }) => Boolean(state?.halted));
  const commands = job.commands.filter(isCommand).filter((name) => only === undefined || name === only);
  return (
    <Group gap={6} role="group" aria-label={t("commands.label")}>
      {commands.map((name) => {
        const { operation, icon: Icon } = COMMANDS[name];
        const grave = GRAVE.find((one) => one === name);
        return (
          <MayButton
            key={name}
            operation={operation}
            variant="default"
            leftSection={<Icon size={14} aria-hidden />}
            loading={command.isPending && command.variables.name === name}
            disabled={halted && (name === "resume" || name === "start")} // the banner says to reset first
            onClick={() => (grave !== undefined ? ask(grave) : command.mutate({ name, comment: "" }))}
          >
            {t(`commands.${name}.name`)}
          </MayButton>
        );
      })}
      {asking !== null && (
        <Sure
          job={job.id}
          command={asking}
          close={() => ask(null)}
          go={(comment) => command.mutate({ name: asking, comment })}
        />
      )}
    </Group>
  );
}

interface SureProps {
  job: string;
  command: Grave;
  close: () => void;
  go: (comment: string) => void;
}

function Sure({ job, command, close, go }: SureProps) {
  const { t } = useTranslation("task");
  const [comment, setComment] = useState("");
  const send = () => {
    close();
    go(comment);
  };
  return (
    <Modal opened onClose={close} title={t(`commands.${command}.sure`, { job })} centered>
      <form
        onSubmit={(event) => {
          event.preventDefault();
          send();
        }}
      >
        <Stack gap="sm">
          <Text size="sm">{t(`commands.${command}.means`)}</Text>
          <TextInput
            label={t("commands.comment")}
            value={comment}
            maxLength={2000}
            onChange={(event) => setComment(event.currentTarget.value)}
            data-autofocus
          />
          <Group justify="end">
            <Button variant="default" onClick={close}>
              {t("commands.no")}
            </Button>
            <Button type="submit" color="red">
              {t(`commands.${command}.name`)}
            </Button>
          </Group>
        </Stack>
      </form>
    </Modal>
  );
}

/** Sends a command for the job as displayed; it is refused if the job has changed meanwhile. */
function useCommand(job: Schema<"Job">, gone: () => void) {
  const client = useQueryClient();
  const readAgain = () => void client.invalidateQueries({ queryKey: keys.jobs() });
  return useSingleMutation({
    mutationFn: ({ name, comment }: { name: Command; comment: string }) => {
      // All commands have the same form and a valid address.
      const path = `/api/v1/jobs/{id}/${name}` as "/api/v1/jobs/{id}/pause";
      return answer(api.POST(path, { params: { path: { id: job.id } }, body: { comment } }));
    },
    onSuccess: (_, { name }) => {
      if (name === "cancel" || name === "clear") gone();
      else readAgain();
    },
    onError: (error) => {
      notifyProblem(error);
      readAgain();
    },
  });
}
