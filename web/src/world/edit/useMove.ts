import { useQueryClient } from "@tanstack/react-query";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, api } from "../../api/client";
import { notifyProblem } from "../../widgets/problems";
import { changeSince, notifyChange } from "../../widgets/undo";
import { useClasses } from "../classes";
import { readElement, type Tagged, useRelations } from "../queries";
import { askFits, type Fit, placementsFor, relationFor } from "./placements";

/** A possible placement of an element. */
export interface Question {
  element: Tagged;
  place: string;
  fits: readonly Fit[];
}

export interface Move {
  /** The question to ask; null for none. */
  question: Question | null;
  /** Moves an element to a place: at once if skills accept a relation there or it can stay the same (in, on), otherwise after a question. */
  move: (element: string, place: string) => void;
  put: (question: Question, relation: string) => void;
  close: () => void;
}

export function useMove(): Move {
  const { t } = useTranslation("world");
  const client = useQueryClient();
  const classes = useClasses();
  const { data: relations } = useRelations();
  const [question, setQuestion] = useState<Question | null>(null);
  const put = (asked: Question, relation: string) => {
    setQuestion(null);
    place(asked, relation).then((moved) => {
      void client.invalidateQueries({ queryKey: ["world"] });
      const said = relations?.find(({ name }) => name === relation)?.label ?? relation;
      const message = t("move.done", { label: moved.label, relation: said, place: asked.place });
      notifyChange(message, changeSince(asked.element.data, moved));
    }, notifyProblem);
  };
  const ask = async (id: string, where: string) => {
    const element = await readElement(id);
    const names = placementsFor(classes, relations ?? [], element.data.class).map(({ name }) => name);
    const asked = { element, place: where, fits: await askFits({ element: id }, where, names) };
    const relation = relationFor(asked.fits, element.data.placement?.relation);
    if (relation === undefined) setQuestion(asked);
    else put(asked, relation);
  };
  return {
    question,
    put,
    move: (id, where) => void ask(id, where).catch(notifyProblem),
    close: () => setQuestion(null),
  };
}

function place({ element, place: where }: Question, relation: string) {
  return answer(
    api.PATCH("/api/v1/elements/{element}", {
      params: { path: { element: element.data.id }, header: { "if-match": element.tag } },
      body: { placement: { relation, place: where }, reason: "" },
    }),
  );
}
