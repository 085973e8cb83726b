/** Candidates for a slot: elements of a class, searched by the server; and classes, if any element will do. */

import { keepPreviousData, useQuery } from "@tanstack/react-query";
import { answer, api } from "../api/client";
import { keys } from "../api/keys";
import { byName, classesOf, classTree, localName, nameOf } from "./names";

export interface Candidate {
  value: string;
  label: string;
  /** Label of its class. */
  kind: string;
}

export interface Candidates {
  classes: Candidate[];
  elements: Candidate[];
  described: Candidate[];
  /** Whether there are further elements. */
  more: boolean;
}

const SHOWN = 50; // longer lists are not read: users type another letter instead
const PAGE = 1000;

/** Searches candidates by a text in id, label or class. */
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
  return { items: named.sort((one, other) => byName(one.label, other.label)), more: next !== null };
}

function candidateOf({ name, label }: { name: string; label: string }): Candidate {
  return { value: name, label: label || localName(name), kind: "" };
}

/** Returns a predicate for candidates whose name contains a text, with the server's rules. */
function says(text: string): (candidate: Candidate) => boolean {
  const wanted = text.toLowerCase();
  return ({ value, label }) => value.toLowerCase().includes(wanted) || label.toLowerCase().includes(wanted);
}

/** Returns the ids of all elements of a class, which can be picked by a click. */
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
