/** The data of a job or a task: fetched once, and again after events. */

import { useQuery } from "@tanstack/react-query";
import { useMemo } from "react";
import { answer, api, ApiProblem, type Schema } from "../api/client";
import { keys } from "../api/keys";
import { useStation } from "../live/station";
import { useReplay } from "../scene3d/replay";
import { cutOff, joined, NO_RUN, readEntry, readRun, type Run, type TraceEntry } from "./trace";

const PAGE = 1000;
const FORGOTTEN_AFTER = 30_000; // ms: they are long, and quickly fetched again
const MOST_PAGES = 10;
const TICKS = 2; // per second of run time: rendering rate of moving parts

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

/** The changes of a job's state, oldest first. */
export function useTransitions({ id, version, state }: Schema<"Job">) {
  return useQuery({
    queryKey: keys.jobs("transitions", id, version, state.text), // a full disk pauses jobs without a new version
    queryFn: () => answer(api.GET("/api/v1/jobs/{id}/transitions", { params: { path: { id } } })),
    staleTime: Number.POSITIVE_INFINITY,
  });
}

/** The history of a job, in the time of its replay while that is shown; ended jobs are fetched once. */
export function useJobRun({ id, number, ended }: Schema<"Job">) {
  const over = ended !== null;
  const query = useQuery({
    queryKey: over ? ["past trace", id, number] : keys.tasks("trace of job", id), // no event invalidates the past
    queryFn: () => (over ? pastHistoryOf(id) : historyOf(id)),
    placeholderData: (before) => before,
    gcTime: FORGOTTEN_AFTER,
  });
  const replay = useReplay((shown) => (shown.replay?.job === id ? shown.replay : null));
  const run = useMemo(() => runOf(query.data, replay), [query.data, replay]);
  return { ...query, run };
}

interface History {
  entries: TraceEntry[];
  /** Whether a task of the running server executes it; false after an interruption by a restart. */
  active: boolean;
}

async function pastHistoryOf(job: string): Promise<History> {
  return { entries: await entriesOfJob(job), active: false };
}

async function historyOf(job: string): Promise<History> {
  const kept = await entriesOfJob(job);
  const { items } = await answer(api.GET("/api/v1/tasks", { params: { query: { active: true, limit: PAGE } } }));
  const active = items.some(({ name }) => name === job);
  return { entries: active ? joined(kept, await entriesOfTask(job)) : kept, active };
}

function runOf(fetched: History | undefined, replay: Schema<"Replay"> | null): Run {
  if (fetched === undefined) return NO_RUN;
  const run = readRun(fetched.entries, replay?.shifts);
  return fetched.active ? run : cutOff(run, replay?.end);
}

export function useTaskRun(name: string) {
  const query = useQuery({ queryKey: keys.tasks("trace", name), queryFn: () => entriesOfTask(name) });
  const run = useMemo(() => (query.data === undefined ? NO_RUN : readRun(query.data)), [query.data]);
  return { ...query, run };
}

async function entriesOfJob(id: string): Promise<TraceEntry[]> {
  const entries: TraceEntry[] = [];
  let cursor: string | undefined = "0";
  for (let pages = 0; cursor !== undefined && pages < MOST_PAGES; pages++) {
    const query = { limit: PAGE, cursor };
    const page: Schema<"JobTrace"> = await answer(
      api.GET("/api/v1/jobs/{id}/trace", { params: { path: { id }, query } }),
    );
    entries.push(...page.items.map(readEntry));
    cursor = page.next ?? undefined;
  }
  return entries;
}

/** The trace of a running task; empty if it has just been removed. */
async function entriesOfTask(name: string): Promise<TraceEntry[]> {
  try {
    const trace = await answer(api.GET("/api/v1/tasks/{name}/trace", { params: { path: { name } } }));
    return trace.items.map(readEntry);
  } catch (error) {
    if (error instanceof ApiProblem && error.status === 404) return [];
    throw error;
  }
}

/** Run time [s], updated a few times a second; components that use it render at that rate. */
export function useNow(): number {
  return useStation((station) => Math.floor((station.state?.time ?? 0) * TICKS) / TICKS);
}
