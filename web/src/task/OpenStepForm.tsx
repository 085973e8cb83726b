import { Alert, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { Versions } from "./ConflictAlert";
import type { Skills } from "../api/cell";
import { type Edit, type Fate, isConflict, type Sequence, type WantedStep } from "./sequences";
import { StepForm } from "./StepForm";
import type { OpenForm } from "./stepForms";
import classes from "./task.module.css";
import { stepTitle } from "./words";

interface Props {
  form: OpenForm;
  fate: Fate;
  sequence: Sequence;
  skills: Skills;
  pending: boolean;
  edit: (edit: Edit, then: { onSettled: (there: unknown, refusal: Error | null) => void }) => void;
  close: () => void;
}

/** The form of an opened step; shows if another person has changed the sequence meanwhile. */
export function OpenStepForm({ form, fate, sequence, skills, pending, edit, close }: Props) {
  const { t } = useTranslation("task");
  const removed = fate.fate === "removed";
  const save = (step: WantedStep) => {
    const change: Edit = removed
      ? { kind: "insert", at: Math.min(form.at, sequence.count), step }
      : { kind: "change", at: fate.at, step };
    edit(change, {
      onSettled: (_, refusal) => {
        if (refusal === null || (removed && isConflict(refusal))) close(); // refused insertions are shown in the alert
      },
    });
  };
  return (
    <li className={classes.step} style={{ listStyle: "none" }}>
      {form.seen.version !== sequence.version && (
        <Alert color="orange" role="alert" title={t("conflict.title")} p="xs" mb="xs">
          <Versions seen={form.seen} there={sequence} skills={skills} />
          <Text size="sm">{notice()}</Text>
        </Alert>
      )}
      <StepForm
        skills={skills}
        step={form.seen.steps[form.at]}
        label={removed ? t("step.add") : t("step.save")}
        pending={pending}
        save={save}
        cancel={close}
      />
    </li>
  );

  function notice(): string {
    if (fate.fate === "removed") return t("conflict.removed");
    const now = sequence.steps[fate.at];
    if (fate.fate === "stays" || now === undefined) return t("conflict.stays", { place: fate.at + 1 });
    return t("conflict.changed", { place: fate.at + 1, step: stepTitle(now, skills) });
  }
}
