/** What is known of a job or a task: read once, and anew when an event says that there is more. */

import { useQuery } from "@tanstack/react-query";
import { useMemo } from "react";
import { answer, api, ApiProblem, type Schema } from "../api/client";
import { keys } from "../api/keys";
import { useStation } from "../live/station";
import type { Skills } from "./schedule";
import { joined, NO_RUN, readEntry, readRun, type Run, type TraceEntry } from "./trace";

const PAGE = 1000;
const MOST_PAGES = 10;
const TICKS = 2; // per second of run time: how often what moves with time is drawn

export function useJob(id: string) {
  return useQuery({
    queryKey: keys.jobs("one", id),
    queryFn: () => answer(api.GET("/api/v1/jobs/{id}", { params: { path: { id } } })),
  });
}

export function useTask(name: string) {
  return useQuery({
    queryKey: keys.tasks("one", name),
    queryFn: () => answer(api.GET("/api/v1/tasks/{name}", { params: { path: { name } } })),
  });
}

/** What happened for a job; of one that is over it is read once. */
export function useJobRun(id: string, over: boolean) {
  const query = useQuery({
    queryKey: over ? keys.jobs("trace", id) : keys.tasks("trace of job", id),
    queryFn: async () => joined(await entriesOfJob(id), await entriesOfTask(id)),
    placeholderData: (before) => before,
  });
  return { ...query, run: useRead(query.data) };
}

export function useTaskRun(name: string) {
  const query = useQuery({ queryKey: keys.tasks("trace", name), queryFn: () => entriesOfTask(name) });
  return { ...query, run: useRead(query.data) };
}

function useRead(entries: TraceEntry[] | undefined): Run {
  return useMemo(() => (entries === undefined ? NO_RUN : readRun(entries)), [entries]);
}

async function entriesOfJob(id: string): Promise<TraceEntry[]> {
  const entries: TraceEntry[] = [];
  let cursor: string | undefined = "0";
  for (let pages = 0; cursor !== undefined && pages < MOST_PAGES; pages++) {
    const query = { limit: PAGE, cursor };
    const page: Schema<"JobTrace"> = await answer(
      api.GET("/api/v1/jobs/{id}/trace", { params: { path: { id }, query } }),
    );
    entries.push(...page.entries.map(readEntry));
    cursor = page.next ?? undefined;
  }
  return entries;
}

/** What a task remembers; nothing where it is forgotten, as all are when the server has been started anew. */
async function entriesOfTask(name: string): Promise<TraceEntry[]> {
  try {
    const trace = await answer(api.GET("/api/v1/tasks/{name}/trace", { params: { path: { name } } }));
    return trace.entries.map(readEntry);
  } catch (error) {
    if (error instanceof ApiProblem && error.status === 404) return [];
    throw error;
  }
}

export function useSkills(): Skills {
  const { data } = useQuery({
    queryKey: keys.modules("skills"),
    queryFn: () => answer(api.GET("/api/v1/skills")),
  });
  return useMemo(() => new Map(data?.map((skill) => [skill.name, skill])), [data]);
}

/** Run time [s], some times a second; what uses it draws itself so often. */
export function useNow(): number {
  return useStation((station) => Math.floor((station.state?.time ?? 0) * TICKS) / TICKS);
}
