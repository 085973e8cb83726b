import { Button, Group, Modal, Stack, Text, Textarea, TextInput } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { IconPlus, type TablerIcon } from "@tabler/icons-react";
import { useQueryClient } from "@tanstack/react-query";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, api } from "../api/client";
import { keys } from "../api/keys";
import { useSingleMutation } from "../api/mutations";
import { useTab } from "../app/useTab";
import { MayButton } from "../widgets/MayButton";
import { detailOf } from "./address";
import { Problem } from "./Problem";
import { type WantedStep, write } from "./sequences";
import { said } from "../i18n/sentences";

const LONGEST = 30; // s, for planning

interface Props {
  /** Id of a job whose last plan is copied; without one the sequence starts empty, or with the plan for a goal. */
  job?: string;
  /** The proposed name. */
  title: string;
  /** Opens the new sequence; by default the tab does. */
  made?: (id: string) => void;
  icon?: TablerIcon;
}

/** Creates a sequence: empty, from a goal, or from a job's plan. */
export function NewSequenceButton({ job, title, made, icon: Icon = IconPlus }: Props) {
  const { t } = useTranslation("task");
  const [opened, { open, close }] = useDisclosure(false);
  const copies = job !== undefined;
  return (
    <>
      <MayButton operation="put_document" variant="default" leftSection={<Icon size={14} aria-hidden />} onClick={open}>
        {t(copies ? "sequence.ofPlan" : "sequence.new")}
      </MayButton>
      <Modal opened={opened} onClose={close} title={t(copies ? "sequence.ofPlan" : "sequence.new")} centered>
        <Form job={job} title={title} close={close} made={made} />
      </Modal>
    </>
  );
}

function Form({ job, title: proposed, close, made }: Props & { close: () => void }) {
  const { t } = useTranslation("task");
  const { t: common } = useTranslation();
  const [, openTab] = useTab();
  const client = useQueryClient();
  const [title, setTitle] = useState(proposed);
  const [goal, setGoal] = useState("");
  const { mutate, isPending, error } = useSingleMutation({
    mutationFn: async () => {
      const steps = job === undefined ? await planned(goal) : await planOf(job);
      const wanted = steps.map(({ skill, arguments: given = {} }) => ({ skill, arguments: given }));
      return write(`sequence-${Math.random().toString(16).slice(2, 10)}`, { title, steps: wanted });
    },
    onSuccess: ({ id }) => {
      void client.invalidateQueries({ queryKey: keys.documents() });
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
        {job === undefined && (
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

async function planOf(job: string): Promise<readonly WantedStep[]> {
  return (await answer(api.GET("/api/v1/jobs/{id}/plan", { params: { path: { id: job } } }))).items;
}

/** The steps of a plan for the goals, one per line; empty without goals. */
async function planned(goal: string): Promise<readonly WantedStep[]> {
  const goals = goal
    .split("\n")
    .map((line) => line.trim())
    .filter(Boolean);
  if (goals.length === 0) return [];
  const asked = await answer(api.POST("/api/v1/previews", { body: { goal: goals, work_master: "", materials: [] } }));
  const params = { path: { id: asked.id }, query: { wait: LONGEST } };
  const preview = await answer(api.GET("/api/v1/previews/{id}", { params }));
  if (preview.state === "planned") return preview.steps;
  throw new Error(preview.reasons.map(said).join("; ") || preview.state);
}
