/** What was looked at in the tab last: it comes back with the tab, but what has begun meanwhile comes first. */

interface Look {
  /** What the address named; empty for nothing. */
  detail: string;
  /** What was under way then, or last before; null for nothing. */
  task: string | null;
}

let last: Look = { detail: "", task: null };

export function remember(look: Look): void {
  last = look;
}

/** What was under way when the list was last shown. */
export function lastTask(): string | null {
  return last.task;
}

/** What to come back to while `task` is under way: empty for that, or for nothing. */
export function comeBack(task: string | null): string {
  return task === null || task === last.task ? last.detail : "";
}
