/** The open forms of a sequence's steps: they stay open when others change it. */

import { useState } from "react";
import { fateOf, type SeenStep, type Sequence } from "./sequences";

export interface OpenForm extends SeenStep {
  key: number;
}

export interface StepForms {
  forms: readonly OpenForm[];
  open: (step: SeenStep) => void;
  close: (key: number) => void;
  /** Registers the version after an edit made here, which needs no notice. */
  follow: (there: Sequence) => void;
}

export function useStepForms(): StepForms {
  const [forms, setForms] = useState<readonly OpenForm[]>([]);
  return {
    forms,
    open: (step) => setForms((all) => [...all, { ...step, key: 1 + Math.max(0, ...all.map(({ key }) => key)) }]),
    close: (key) => setForms((all) => all.filter((form) => form.key !== key)),
    follow: (there) => setForms((all) => all.map((form) => followed(form, there))),
  };
}

function followed(form: OpenForm, there: Sequence): OpenForm {
  const now = fateOf(form, there);
  return now.fate === "stays" ? { ...form, seen: there, at: now.at } : form;
}
