import { Button, Group, Modal, Stack, Text, Textarea, TextInput } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { IconPlus, type TablerIcon } from "@tabler/icons-react";
import { useQueryClient } from "@tanstack/react-query";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, api, type Schema } from "../api/client";
import { keys } from "../api/keys";
import { useSingleMutation } from "../api/mutations";
import { useTab } from "../app/useTab";
import { MayButton } from "../widgets/MayButton";
import { detailOf } from "./address";
import { Problem } from "./Problem";

interface Props {
  /** What its steps are those of: a job, a task or a preview; of nothing, or of a goal that is asked for. */
  from: Pick<Schema<"NewSequence">, "job" | "task" | "preview">;
  /** Name that is proposed. */
  title: string;
  /** Shows it when it was made; else the tab does. */
  made?: (id: string) => void;
  icon?: TablerIcon;
}

/** Makes a sequence: empty, of a goal, or of the plan of something. */
export function NewSequenceButton({ from, title, made, icon: Icon = IconPlus }: Props) {
  const { t } = useTranslation("task");
  const [opened, { open, close }] = useDisclosure(false);
  const copies = Object.keys(from).length > 0;
  return (
    <>
      <MayButton
        operation="create_sequence"
        variant="default"
        leftSection={<Icon size={14} aria-hidden />}
        onClick={open}
      >
        {t(copies ? "sequence.ofPlan" : "sequence.new")}
      </MayButton>
      <Modal opened={opened} onClose={close} title={t(copies ? "sequence.ofPlan" : "sequence.new")} centered>
        <Form from={from} title={title} copies={copies} close={close} made={made} />
      </Modal>
    </>
  );
}

function Form({ from, title: proposed, copies, close, made }: Props & { copies: boolean; close: () => void }) {
  const { t } = useTranslation("task");
  const { t: common } = useTranslation();
  const [, openTab] = useTab();
  const client = useQueryClient();
  const [title, setTitle] = useState(proposed);
  const [goal, setGoal] = useState("");
  const { mutate, isPending, error } = useSingleMutation({
    mutationFn: () => {
      const goals = goal
        .split("\n")
        .map((line) => line.trim())
        .filter(Boolean);
      const body = { title, ...from, ...(goals.length > 0 && { goal: goals }) };
      return answer(api.POST("/api/v1/sequences", { body }));
    },
    onSuccess: ({ id }) => {
      void client.invalidateQueries({ queryKey: keys.sequences() });
      close();
      if (made === undefined) openTab("task", detailOf({ kind: "sequence", id }));
      else made(id);
    },
  });
  return (
    <form
      onSubmit={(event) => {
        event.preventDefault();
        mutate();
      }}
    >
      <Stack gap="sm">
        <TextInput
          label={t("sequence.title")}
          value={title}
          maxLength={200}
          onChange={(event) => setTitle(event.currentTarget.value)}
          data-autofocus
        />
        {!copies && (
          <Textarea
            label={t("sequence.goal")}
            description={t("sequence.goalHelp")}
            placeholder="InKit(Starter, kit_1)"
            autosize
            minRows={2}
            value={goal}
            onChange={(event) => setGoal(event.currentTarget.value)}
          />
        )}
        {error !== null && <Problem error={error} />}
        {isPending && goal !== "" && <Text size="sm">{t("job.planning")}</Text>}
        <Group justify="end">
          <Button variant="default" onClick={close}>
            {common("cancel")}
          </Button>
          <Button type="submit" loading={isPending}>
            {t("sequence.make")}
          </Button>
        </Group>
      </Stack>
    </form>
  );
}
