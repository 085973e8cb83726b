import { useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, api } from "../../api/client";
import { useSingleMutation } from "../../api/mutations";
import { ApiProblem } from "../../api/client";
import { isUnanswered, notifyProblem } from "../../widgets/problems";
import { changeSince, notifyChange } from "../../widgets/undo";
import { readElement, type Tagged } from "../queries";
import { changedFields, type Draft, draftOf, onTop, patchOf, unfitFields } from "./draft";
import { refusalOf } from "./refusals";
import { useNotAccepted } from "./useNotAccepted";
import { useQueryClient } from "@tanstack/react-query";

const STALE = 412;

/** The form of an edited element. */
export interface Editing {
  before: Draft;
  draft: Draft;
  setDraft: (draft: Draft) => void;
  reason: string;
  setReason: (reason: string) => void;
  changed: boolean;
  /** Fields with missing or malformed numbers, which prevent saving. */
  unfit: readonly string[];
  saving: boolean;
  save: () => void;
  /** The faults in a refusal, by field and without one. */
  errors: Readonly<Record<string, string>>;
  rest: readonly string[];
  /** The version of others that prevents saving. */
  theirs: Tagged | null;
  /** Writes my changes over theirs. */
  saveOnTop: () => void;
  /** Dismisses the conflict and continues editing. */
  goOn: () => void;
}

interface Order {
  before: Draft;
  after: Draft;
  tag: string;
}

export function useEditing(tagged: Tagged, onDone: () => void): Editing {
  const { t } = useTranslation("world");
  const id = tagged.data.id;
  const client = useQueryClient();
  const [base, setBase] = useState(tagged); // the version at the start, regardless of later ones
  const before = draftOf(base.data);
  const [draft, setDraft] = useState(before);
  const [reason, setReason] = useState("");
  const [theirs, setTheirs] = useState<Tagged | null>(null);
  const [refusal, setRefusal] = useState<Error | null>(null);
  const write = useSingleMutation({
    mutationFn: (order: Order) => patch(id, order, reason),
    onSuccess: (now) => {
      void client.invalidateQueries({ queryKey: ["world"] });
      notifyChange(t("edit.done", { label: now.label }), changeSince(base.data, now));
      onDone();
    },
    onError: (error) => void refused(error),
  });
  const refused = async (error: Error) => {
    if (!(error instanceof ApiProblem) || isUnanswered(error)) return notifyProblem(error);
    if (error.status !== STALE) return setRefusal(error);
    await readElement(id).then(setTheirs, notifyProblem);
  };
  const saveOnTop = () => {
    if (theirs === null) return;
    const now = draftOf(theirs.data);
    const after = onTop(before, draft, now);
    setBase(theirs);
    setDraft(after);
    setTheirs(null);
    write.mutate({ before: now, after, tag: theirs.tag });
  };
  const unfit = unfitFields(draft);
  const notAccepted = useNotAccepted(tagged.data.class, draft);
  const { byField, rest } = refusalOf(refusal, { ...before, ...draft }, notAccepted);
  return {
    before,
    draft,
    setDraft,
    reason,
    setReason,
    changed: changedFields(before, draft).length > 0,
    unfit,
    saving: write.isPending,
    save: () => {
      if (unfit.length > 0) return;
      setRefusal(null);
      write.mutate({ before, after: draft, tag: base.tag });
    },
    errors: byField,
    rest,
    theirs,
    saveOnTop,
    goOn: () => setTheirs(null),
  };
}

function patch(element: string, { before, after, tag }: Order, reason: string) {
  return answer(
    api.PATCH("/api/v1/elements/{element}", {
      params: { path: { element }, header: { "if-match": tag } },
      body: patchOf(before, after, reason),
    }),
  );
}
