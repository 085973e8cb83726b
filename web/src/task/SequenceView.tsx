import { Alert, Button, Group, Stack, Text, Title } from "@mantine/core";
import { IconPlus, IconTrash } from "@tabler/icons-react";
import { useQueryClient } from "@tanstack/react-query";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { keys } from "../api/keys";
import { useSingleMutation } from "../api/mutations";
import { useTab } from "../app/useTab";
import { MayButton } from "../widgets/MayButton";
import { notifyProblem } from "../widgets/problems";
import { Status } from "../widgets/Status";
import { ConflictAlert } from "./ConflictAlert";
import { Problem } from "./Problem";
import { RunSequence } from "./RunSequence";
import { isConflict, remove, type Sequence, useEdits, useSequence, type WantedStep } from "./sequences";
import { SequenceSteps } from "./SequenceSteps";
import { StepForm } from "./StepForm";
import { useStepForms } from "./stepForms";
import { type Skills, useSkills } from "../api/cell";
import { HistoryButtons } from "../widgets/HistoryButtons";

/** A sequence of steps that a person creates, edits and runs. */
export default function SequenceView({ id }: { id: string }) {
  const { data: sequence, error, refetch } = useSequence(id);
  const skills = useSkills();
  if (error !== null && sequence === undefined) return <Problem error={error} again={refetch} />;
  if (sequence === undefined) return null;
  return <Known sequence={sequence} skills={skills} />;
}

function Known({ sequence, skills }: { sequence: Sequence; skills: Skills }) {
  const { t } = useTranslation("task");
  const forms = useStepForms();
  const { edit, isPending, conflict, drop, history } = useEdits(sequence, forms.follow);
  const title = sequence.title || sequence.id;
  return (
    <Stack gap="sm" component="article" aria-label={t("sequence.label", { title })}>
      <Group gap="xs">
        <Title order={3} size="h4">
          {title}
        </Title>
        <Works sequence={sequence} />
        <HistoryButtons operation="put_document" {...history} busy={isPending} />
        <Remove sequence={sequence} />
      </Group>
      {conflict !== null && <ConflictAlert conflict={conflict} skills={skills} again={edit} drop={drop} />}
      {sequence.count === 0 && <Text c="dimmed">{t("sequence.empty")}</Text>}
      <SequenceSteps sequence={sequence} skills={skills} pending={isPending} edit={edit} forms={forms} />
      <NewStep
        skills={skills}
        pending={isPending}
        insert={(step, onSettled) => edit({ kind: "insert", at: sequence.count, step }, { onSettled })}
      />
      <RunSequence sequence={sequence} />
    </Stack>
  );
}

function Works({ sequence }: { sequence: Sequence }) {
  const { t } = useTranslation("task");
  if (sequence.count === 0) return null;
  if (sequence.works) return <Status mood="good" text={t("sequence.works")} />;
  const wrong = sequence.steps.filter(({ works }) => !works).length;
  return <Status mood="warning" text={t("sequence.worksNot", { count: wrong })} />;
}

interface NewStepProps {
  skills: Skills;
  pending: boolean;
  insert: (step: WantedStep, settled: (step: unknown, refusal: Error | null) => void) => void;
}

function NewStep({ skills, pending, insert }: NewStepProps) {
  const { t } = useTranslation("task");
  const [opened, setOpened] = useState(false);
  if (!opened) {
    return (
      <Group>
        <MayButton
          operation="put_document"
          variant="light"
          leftSection={<IconPlus size={14} aria-hidden />}
          onClick={() => setOpened(true)}
        >
          {t("step.new")}
        </MayButton>
      </Group>
    );
  }
  const close = () => setOpened(false);
  // A refused form keeps its input; conflicts are shown in the alert.
  const save = (step: WantedStep) =>
    insert(step, (_, refusal) => {
      if (refusal === null || isConflict(refusal)) close();
    });
  return <StepForm skills={skills} label={t("step.add")} pending={pending} save={save} cancel={close} />;
}

function Remove({ sequence }: { sequence: Sequence }) {
  const { t } = useTranslation("task");
  const { t: common } = useTranslation();
  const [sure, ask] = useState(false);
  const client = useQueryClient();
  const [, open] = useTab();
  const { mutate, isPending } = useSingleMutation({
    mutationFn: () => remove(sequence),
    onSuccess: () => {
      void client.invalidateQueries({ queryKey: keys.documents() });
      open("task");
    },
    onError: notifyProblem,
  });
  if (!sure) {
    return (
      <MayButton
        operation="remove_document"
        variant="subtle"
        ml="auto"
        leftSection={<IconTrash size={14} aria-hidden />}
        onClick={() => ask(true)}
      >
        {t("sequence.remove")}
      </MayButton>
    );
  }
  return (
    <Alert color="red" p="xs" w="100%">
      <Group gap="xs" justify="end">
        <Text size="sm">{t("sequence.sure")}</Text>
        <Button variant="default" onClick={() => ask(false)}>
          {common("cancel")}
        </Button>
        <Button color="red" loading={isPending} onClick={() => mutate()}>
          {t("sequence.remove")}
        </Button>
      </Group>
    </Alert>
  );
}
