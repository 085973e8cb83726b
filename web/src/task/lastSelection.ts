/** The last selection of the tab, restored on return unless another task has started meanwhile. */

interface Look {
  /** The selection in the address; empty for none. */
  detail: string;
  /** The task running then, or the last one before; null for none. */
  task: string | null;
}

let last: Look = { detail: "", task: null };

export function remember(look: Look): void {
  last = look;
}

/** The task that ran when the list was last shown. */
export function lastTask(): string | null {
  return last.task;
}

/** The selection to restore while `task` runs: empty for the task itself, or for none. */
export function selectionToRestore(task: string | null): string {
  return task === null || task === last.task ? last.detail : "";
}
