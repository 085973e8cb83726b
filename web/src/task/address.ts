/** The address of the tab: a job by its id alone, for short links, or another entry. */

export type Place = { kind: "job" | "task" | "sequence"; id: string };

const PREFIXES = { task: "tasks/", sequence: "sequences/" } as const; // ids of jobs contain no "/"

export function placeOf(detail: string): Place | null {
  if (detail === "") return null;
  for (const kind of ["task", "sequence"] as const) {
    if (detail.startsWith(PREFIXES[kind])) return { kind, id: detail.slice(PREFIXES[kind].length) };
  }
  return { kind: "job", id: detail };
}

export function detailOf({ kind, id }: Place): string {
  return kind === "job" ? id : PREFIXES[kind] + id;
}
