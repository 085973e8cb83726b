/** Events of the server, passed on to listeners. */

import type { Schema } from "../api/client";

export type EventInfo = Schema<"EventInfo">;

/** Each is a name of its own in the stream, which has to be asked for. */
export const EVENT_KINDS: readonly EventInfo["kind"][] = [
  "world",
  "module",
  "task",
  "job",
  "alarm",
  "document",
  "system",
];

const listeners = new Set<(event: EventInfo) => void>();
const resetListeners = new Set<() => void>();

/** Calls a function at each event; returns how to end that. */
export function onEvent(listener: (event: EventInfo) => void): () => void {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

/** Calls a function when events may have been missed, so that everything has to be read again. */
export function onReset(listener: () => void): () => void {
  resetListeners.add(listener);
  return () => resetListeners.delete(listener);
}

export function tellEvent(event: EventInfo): void {
  for (const listener of listeners) listener(event);
}

export function tellReset(): void {
  for (const listener of resetListeners) listener();
}
