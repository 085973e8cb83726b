/** What may fill a slot: elements of a class, found by the server; and, where a kind will do, classes. */

import { keepPreviousData, useQuery } from "@tanstack/react-query";
import { answer, api } from "../api/client";
import { keys } from "../api/keys";
import { classesOf, classTree, localName, nameOf } from "./names";

export interface Candidate {
  value: string;
  label: string;
  /** Its class, in words. */
  kind: string;
}

export interface Candidates {
  classes: Candidate[];
  elements: Candidate[];
  described: Candidate[];
  /** Whether there are more elements than these. */
  more: boolean;
}

const SHOWN = 50; // longer lists are not read: one types another letter
const PAGE = 1000;

/** Finds candidates by a text in id, label or class. */
export function useCandidates(class_: string, abstract: boolean, text: string, enabled: boolean) {
  const elements = useQuery({
    queryKey: keys.world("candidates", class_, text),
    queryFn: () => found(class_, text, false),
    placeholderData: keepPreviousData,
    enabled,
  });
  const described = useQuery({
    queryKey: keys.ontology("candidates", class_, text),
    queryFn: () => found(class_, text, true),
    placeholderData: keepPreviousData,
    enabled: enabled && abstract,
  });
  const { data: tree } = useQuery({ ...classTree(class_), enabled: abstract });
  const candidates: Candidates = {
    classes: abstract && tree ? classesOf(tree).map(candidateOf).filter(says(text)) : [],
    elements: elements.data?.items ?? [],
    described: (abstract && described.data?.items) || [],
    more: elements.data?.more ?? false,
  };
  return { candidates, isFetching: elements.isFetching };
}

async function found(class_: string, text: string, abstract: boolean) {
  const query = { class: class_, text: text || undefined, abstract, limit: SHOWN };
  const { items, next } = await answer(api.GET("/api/v1/elements", { params: { query } }));
  const named = items.map(({ id, label, class: kind }) => ({
    value: id,
    label: nameOf(id, label),
    kind: localName(kind),
  }));
  return { items: named, more: next !== null };
}

function candidateOf({ name, label }: { name: string; label: string }): Candidate {
  return { value: name, label: label || localName(name), kind: "" };
}

/** Returns a test whether a candidate has a text in its name, as the server does for elements. */
function says(text: string): (candidate: Candidate) => boolean {
  const wanted = text.toLowerCase();
  return ({ value, label }) => value.toLowerCase().includes(wanted) || label.toLowerCase().includes(wanted);
}

/** Returns the ids of all elements of a class: those that a click may choose. */
export async function idsOf(class_: string): Promise<Set<string>> {
  const ids = new Set<string>();
  let cursor: string | null = null;
  do {
    const query: { class: string; limit: number; cursor: string | null } = { class: class_, limit: PAGE, cursor };
    const page = await answer(api.GET("/api/v1/elements", { params: { query } }));
    for (const { id } of page.items) ids.add(id);
    cursor = page.next;
  } while (cursor !== null);
  return ids;
}
