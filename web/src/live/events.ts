/** The server's events, passed on to listeners. */

import type { Schema } from "../api/client";

export type EventInfo = Schema<"EventInfo">;

/** The event types of the stream: `EventSource` needs a listener for each by name. */
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

/** Calls a function at each event; returns the function that unsubscribes it. */
export function onEvent(listener: (event: EventInfo) => void): () => void {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

/** Calls a function when events may have been missed, so that all data must be fetched again. */
export function onReset(listener: () => void): () => void {
  resetListeners.add(listener);
  return () => resetListeners.delete(listener);
}

export function emitEvent(event: EventInfo): void {
  for (const listener of listeners) listener(event);
}

export function emitReset(): void {
  for (const listener of resetListeners) listener();
}
