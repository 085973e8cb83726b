/** Makes what was read old when an event says so; many events in a row do it once. */

import { queryClient } from "../api/queries";
import { type EventInfo, onEvent, onReset } from "./events";

/** Which kept answers (by the first word of their key) an event makes old. */
const OLD_BY: Record<EventInfo["kind"], readonly string[]> = {
  world: ["world", "goals", "scenes"],
  module: ["module-runs"],
  task: ["tasks"],
  job: ["jobs", "tasks"],
  alarm: ["alarms", "jobs"],
  system: ["station", "modules", "robots", "goals", "alarms", "tasks", "jobs", "scenes", "ontology", "world", "me"],
};
const PAUSE = 80; // ms: more often nobody sees it, and two cores have other work

/** Begins; returns how to end it. */
export function keepFresh(): () => void {
  const old = new Set<string>();
  let timer: ReturnType<typeof setTimeout> | undefined;
  const refresh = () => {
    timer = undefined;
    const words = new Set(old);
    old.clear();
    void queryClient.invalidateQueries({ predicate: ({ queryKey }) => words.has(String(queryKey[0])) });
  };
  const age = (words: readonly string[]) => {
    for (const word of words) old.add(word);
    timer ??= setTimeout(refresh, PAUSE);
  };
  const endings = [onEvent((event) => age(OLD_BY[event.kind])), onReset(() => void queryClient.invalidateQueries())];
  return () => {
    clearTimeout(timer);
    for (const end of endings) end();
  };
}
