/** Invalidates cached queries after events and for another language; a burst of events invalidates them once. */

import type { Query } from "@tanstack/react-query";
import { queryClient } from "../api/queries";
import i18n from "../i18n";
import { type EventInfo, onEvent, onReset } from "./events";

/** The queries that each kind of event invalidates, by the first word of their keys. */
const INVALIDATED_BY: Record<EventInfo["kind"], readonly string[]> = {
  world: ["world", "goals", "scenes"],
  module: ["module-runs"],
  task: ["tasks"],
  job: ["jobs", "tasks"],
  alarm: ["alarms", "jobs"],
  document: ["documents", "world"], // answers about a sequence contain the state of the world
  system: [
    "station",
    "modules",
    "robots",
    "goals",
    "alarms",
    "tasks",
    "jobs",
    "scenes",
    "ontology",
    "world",
    "documents",
    "me",
  ],
};
/** The queries with labels and comments of the ontology, which the server answers in the language of the pages. */
const WORDED = ["ontology", "world"];
/** Labels are fetched one by one, and therefore only invalidated by changes that may have renamed an element. */
const NAMES = "names";
const LABEL = "rdfs:label";
const PAUSE = 80; // ms: more frequent updates are not visible, and cost computing time

/** Starts invalidating queries; returns the function that stops it. */
export function keepFresh(): () => void {
  let stale = new Set<string>();
  let pending = new Set<string>();
  let timer: ReturnType<typeof setTimeout> | undefined;
  const refresh = (isStale = (query: Query) => stale.has(String(query.queryKey[0]))) => {
    pending = invalidate((query) => isStale(query) || pending.has(query.queryHash));
    stale = new Set();
    clearTimeout(timer);
    timer = pending.size > 0 ? setTimeout(refresh, PAUSE) : undefined;
  };
  const markStale = (words: readonly string[]) => {
    for (const word of words) stale.add(word);
    timer ??= setTimeout(refresh, PAUSE);
  };
  const invalidateAll = () => refresh(() => true);
  const markWorded = () => markStale(WORDED);
  i18n.on("languageChanged", markWorded);
  const endings = [
    onEvent((event) => (isOpened(event) ? invalidateAll() : markStale(keysOf(event)))),
    onReset(invalidateAll),
    () => i18n.off("languageChanged", markWorded),
  ];
  return () => {
    clearTimeout(timer);
    for (const end of endings) end();
  };
}

/**
 * Invalidates queries; returns the hashes of those being fetched.
 *
 * Those must be invalidated after their answer, which may predate the event. If they were cancelled at each event
 * instead, a slow query would never finish while robots work. A query's first fetch is never cancelled.
 */
function invalidate(isStale: (query: Query) => boolean): Set<string> {
  const busy = queryClient.getQueryCache().findAll({ predicate: isStale, fetchStatus: "fetching" });
  const fetching = new Set(busy.map(({ queryHash }) => queryHash));
  void queryClient.invalidateQueries({ predicate: (query) => isStale(query) && !fetching.has(query.queryHash) });
  return fetching;
}

/** Whether another scene or another run of the server was opened, so that ids and numbers refer to other things. */
function isOpened({ kind, type }: EventInfo): boolean {
  return kind === "system" && type === "opened";
}

function keysOf(event: EventInfo): readonly string[] {
  return mayRename(event) ? [...INVALIDATED_BY[event.kind], NAMES] : INVALIDATED_BY[event.kind];
}

function mayRename({ kind, data }: EventInfo): boolean {
  if (kind !== "world" || !Array.isArray(data.edits)) return false;
  const edits = data.edits as { edit?: unknown; property?: unknown }[];
  const isCut = data.all_edits !== undefined; // long changes are sent in part
  return isCut || edits.some(({ edit, property }) => edit === "element" || property === LABEL);
}
