/** The words for which the present robots have skills. */

import { useQuery } from "@tanstack/react-query";
import { useEffect } from "react";
import { useTranslation } from "react-i18next";
import { answer, api } from "../api/client";
import { keys } from "../api/keys";
import { queryClient } from "../api/queries";
import { type EventInfo, onEvent } from "../live/events";
import { type ConditionWord, plainSentence, type Piece, piecesOf, sentenceOfHelp } from "./sentence";

const KEY = keys.modules("goal-words");
const NONE: readonly ConditionWord[] = [];

/** The condition words, and a function to fetch them again. */
export function useWords() {
  const { data, refetch, isFetching } = useQuery({
    queryKey: KEY,
    queryFn: () => answer(api.GET("/api/v1/goals/conditions")),
    select: ({ items }) => items,
  });
  return { words: data ?? NONE, refetch, isFetching, known: data !== undefined };
}

/** Fetches the words again when skill managers may have changed; once for all users of this hook. */
export function useFreshWords(): void {
  useEffect(
    () => onEvent((event) => void (mayChangeSkills(event) && queryClient.invalidateQueries({ queryKey: KEY }))),
    [],
  );
}

/** Whether skill managers may have changed: skills are elements, which no job adds or removes. */
function mayChangeSkills({ kind, data }: EventInfo): boolean {
  if (kind === "alarm") return "kind" in data && data.kind === "manager";
  if (kind !== "world" || !Array.isArray(data.edits)) return false;
  return data.edits.some(
    (edit: unknown) => typeof edit === "object" && edit !== null && "edit" in edit && edit.edit === "element",
  );
}

/** Returns a function that writes a condition as a sentence with slots, translated if we have a translation. */
export function useSentence(): (word: ConditionWord) => Piece[] {
  const { t } = useTranslation("goal");
  const ours: Record<string, string> = t("words", { returnObjects: true });
  return (word) => piecesOf(ours[word.name] ?? sentenceOfHelp(word) ?? plainSentence(word), word.roles);
}
