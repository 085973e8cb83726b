/** Taking back what was just written to the world. */

import { answer, api } from "../api/client";
import { queryClient } from "../api/queries";
import { notifyProblem } from "./problems";
import { notifyDone } from "./toasts";

/**
 * Says that the world was changed, and offers to take that very change back.
 *
 * @param change - Its number; null where everything was so already.
 */
export function notifyChange(message: string, change: number | null | undefined): void {
  notifyDone(message, change ? () => void undo(change).catch(notifyProblem) : undefined);
}

/** Takes back a change, as long as it is still the last one of a person; what was read of the world is old then. */
export async function undo(change: number): Promise<void> {
  await answer(api.POST("/api/v1/world/undo", { body: { change } }));
  for (const word of ["world", "scenes"]) void queryClient.invalidateQueries({ queryKey: [word] });
}

interface Versioned {
  version: number;
}

/** The number of the change that made an element what it is now; null where it still is as it was seen. */
export function changeSince(seen: Versioned, now: Versioned): number | null {
  return now.version === seen.version ? null : now.version; // the version of an element is its last change's number
}
