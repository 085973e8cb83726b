/** Makes what was read old when an event says so; many events in a row do it once. */

import type { Query } from "@tanstack/react-query";
import { queryClient } from "../api/queries";
import { type EventInfo, onEvent, onReset } from "./events";

/** Which kept answers (by the first word of their key) an event makes old. */
const OLD_BY: Record<EventInfo["kind"], readonly string[]> = {
  world: ["world", "goals", "scenes"],
  module: ["module-runs"],
  task: ["tasks"],
  job: ["jobs", "tasks"],
  alarm: ["alarms", "jobs"],
  document: ["documents", "world"], // a sequence is read with the state of the world
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
/** What people call things: asked for one by one, therefore only after a change that may have renamed some. */
const NAMES = "names";
const LABEL = "rdfs:label";
const PAUSE = 80; // ms: more often is not visible, and costs computing time

/** Begins; returns how to end it. */
export function keepFresh(): () => void {
  let old = new Set<string>();
  let late = new Set<string>();
  let timer: ReturnType<typeof setTimeout> | undefined;
  const refresh = () => {
    late = makeOld(old, late);
    old = new Set();
    timer = late.size > 0 ? setTimeout(refresh, PAUSE) : undefined;
  };
  const age = (words: readonly string[]) => {
    for (const word of words) old.add(word);
    timer ??= setTimeout(refresh, PAUSE);
  };
  const ageAll = () => void queryClient.invalidateQueries();
  const endings = [onEvent((event) => (isOpened(event) ? ageAll() : age(oldBy(event)))), onReset(ageAll)];
  return () => {
    clearTimeout(timer);
    for (const end of endings) end();
  };
}

/**
 * Makes queries old by the first words of their keys, or by their hashes; returns the hashes of those that are being read.
 *
 * These have to wait until they were answered: what is under way may have been answered before the event, and if it
 * was cancelled at each event instead, a slow answer would never come through while robots work.
 */
function makeOld(words: ReadonlySet<string>, hashes: ReadonlySet<string>): Set<string> {
  const isOld = ({ queryKey, queryHash }: Query) => words.has(String(queryKey[0])) || hashes.has(queryHash);
  const busy = queryClient.getQueryCache().findAll({ predicate: isOld, fetchStatus: "fetching" });
  const late = new Set(busy.map(({ queryHash }) => queryHash));
  void queryClient.invalidateQueries({ predicate: (query) => isOld(query) && !late.has(query.queryHash) });
  return late;
}

/** Another scene, or another run of the server: ids and numbers mean other things now. */
function isOpened({ kind, type }: EventInfo): boolean {
  return kind === "system" && type === "opened";
}

function oldBy(event: EventInfo): readonly string[] {
  return mayRename(event) ? [...OLD_BY[event.kind], NAMES] : OLD_BY[event.kind];
}

function mayRename({ kind, data }: EventInfo): boolean {
  if (kind !== "world" || !Array.isArray(data.edits)) return false;
  const edits = data.edits as { edit?: unknown; property?: unknown }[];
  const isCut = data.all_edits !== undefined; // of a long change only a part is sent
  return isCut || edits.some(({ edit, property }) => edit === "element" || property === LABEL);
}
