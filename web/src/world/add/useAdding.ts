import { useQueryClient } from "@tanstack/react-query";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, api, type Schema } from "../../api/client";
import { useSingleMutation } from "../../api/mutations";
import { useSelection } from "../../selection/selection";
import { isUnanswered, notifyProblem } from "../../widgets/problems";
import { notifyChange } from "../../widgets/undo";
import { useClasses } from "../classes";
import { type Draft, given, LABEL, PLACEMENT, unfitFields } from "../edit/draft";
import { refusalOf } from "../edit/refusals";
import { useNotAccepted } from "../edit/useNotAccepted";
import { placementsFor } from "../edit/placements";
import { type Details, type Placement, useRelations } from "../queries";
import { isPose } from "../values";

const POSE = "sk:pose";
const ASIDE = 0.1; // m: a copy must not stand inside its original

/** The form of an element to add. */
export interface Adding {
  /** The class, or the abstract individual to copy. */
  what: string | null;
  class_: string | null;
  choose: (what: string | null, class_: string | null) => void;
  draft: Draft;
  setDraft: (draft: Draft) => void;
  reason: string;
  setReason: (reason: string) => void;
  /** Fields with missing or malformed numbers, which prevent saving. */
  unfit: readonly string[];
  saving: boolean;
  save: () => void;
  errors: Readonly<Record<string, string>>;
  rest: readonly string[];
}

export function useAdding(parent: Details | null, like: Details | undefined, onDone: () => void): Adding {
  const { t } = useTranslation("world");
  const client = useQueryClient();
  const classes = useClasses();
  const { data: relations } = useRelations();
  const [what, setWhat] = useState<string | null>(like?.id ?? null);
  const [class_, setClass] = useState<string | null>(like?.class ?? null);
  const [draft, setDraft] = useState<Draft>(() => (like ? copied(like) : {}));
  const [reason, setReason] = useState("");
  const [refusal, setRefusal] = useState<Error | null>(null);
  const write = useSingleMutation({
    mutationFn: (body: Schema<"NewElement">) => answer(api.POST("/api/v1/elements", { body })),
    onSuccess: ({ id, label, version }) => {
      void client.invalidateQueries({ queryKey: ["world"] });
      notifyChange(t("add.done", { label, id }), version);
      useSelection.getState().choose(id);
      onDone();
    },
    onError: (error) => (isUnanswered(error) ? notifyProblem(error) : setRefusal(error)),
  });
  const choose = (next: string | null, kind: string | null) => {
    setWhat(next);
    setClass(kind);
    const first = kind && parent ? placementsFor(classes, relations ?? [], kind, parent.class)[0] : undefined;
    setDraft(first && parent ? { [PLACEMENT]: { relation: first.name, place: parent.id } } : {});
  };
  const unfit = unfitFields(draft);
  const { byField, rest } = refusalOf(refusal, draft, useNotAccepted(class_, draft));
  const copy = what !== null && what !== class_;
  return {
    what,
    class_,
    choose,
    draft,
    setDraft,
    reason,
    setReason,
    unfit,
    saving: write.isPending,
    save: () => {
      if (unfit.length > 0) return;
      setRefusal(null);
      if (what !== null) write.mutate(newElement(what, copy, draft, reason));
    },
    errors: byField,
    rest,
  };
}

function copied(like: Details): Draft {
  const pose = like.properties[POSE];
  const own = pose?.origin === "own" && isPose(pose.value) ? { [POSE]: beside(pose.value) } : {};
  return { [LABEL]: like.label, [PLACEMENT]: like.placement, ...own };
}

function beside<Pose extends { position: readonly number[] }>(pose: Pose): Pose {
  const [x = 0, y = 0, z = 0] = pose.position;
  return { ...pose, position: [x + ASIDE, y + ASIDE, z] };
}

function newElement(what: string, copy: boolean, draft: Draft, reason: string): Schema<"NewElement"> {
  const { [LABEL]: label, [PLACEMENT]: placement, ...own } = draft;
  const properties = Object.entries(own).map(([name, value]) => [name, given(name, value)]);
  return {
    ...(copy ? { like: what } : { class: what }),
    ...(label ? { label: String(label) } : {}),
    ...(placement ? { placement: placement as Placement } : {}),
    properties: Object.fromEntries(properties.filter(([, value]) => value !== null)),
    reason,
  };
}
