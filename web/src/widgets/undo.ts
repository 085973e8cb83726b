/** Undo of the last change of the world. */

import { answer, api } from "../api/client";
import { queryClient } from "../api/queries";
import { notifyProblem } from "./problems";
import { notifyDone } from "./toasts";

/**
 * Reports a change of the world, and offers to undo it.
 *
 * @param change - Its number; null if nothing changed.
 */
export function notifyChange(message: string, change: number | null | undefined): void {
  notifyDone(message, change ? () => void undo(change).catch(notifyProblem) : undefined);
}

/** Undoes a change if it is still the last one by a person; invalidates the queries of the world. */
export async function undo(change: number): Promise<void> {
  await answer(api.POST("/api/v1/world/undo", { body: { change } }));
  for (const word of ["world", "scenes"]) void queryClient.invalidateQueries({ queryKey: [word] });
}

interface Versioned {
  version: number;
}

/** Number of the last change of an element since it was displayed; null if there is none. */
export function changeSince(seen: Versioned, now: Versioned): number | null {
  return now.version === seen.version ? null : now.version; // the version is the number of the last change
}
