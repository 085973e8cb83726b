/** The jobs of a period, latest first: fetched once, then only changes. */

import { useQuery, useQueryClient } from "@tanstack/react-query";
import { useEffect } from "react";
import { answer, api, type Schema } from "../api/client";
import { keys } from "../api/keys";
import { onEvent } from "../live/events";

type Job = Schema<"Job">;

export const PERIODS = { hour: 3600, day: 86_400, week: 604_800, all: null } as const; // s
export type Period = keyof typeof PERIODS;

const PAGE = 1000;
const MOST = 5000;

export function useJobs(period: Period) {
  const client = useQueryClient();
  const queryKey = keys.jobs("list", period);
  useEffect(() => forgetRemoved(client, keys.jobs("list", period)), [client, period]);
  return useQuery({
    queryKey,
    queryFn: async () => {
      const known = client.getQueryData<Job[]>(queryKey) ?? [];
      return merged(known, await newest(lastMoment(known) ?? beginning(period)));
    },
  });
}

/** Merges newly fetched jobs into the known ones; latest order first. */
export function merged(known: readonly Job[], read: readonly Job[]): Job[] {
  const jobs = new Map(known.map((job) => [job.id, job]));
  for (const job of read) jobs.set(job.id, job);
  return [...jobs.values()].sort((one, other) => other.number - one.number).slice(0, MOST);
}

/** The latest time mentioned in jobs, by the server's clock: later changes must still be fetched. */
export function lastMoment(jobs: readonly Job[]): string | undefined {
  const moments = jobs.flatMap(({ ordered, started, ended }) => [ordered, started, ended]);
  return moments.filter((moment) => moment !== null).reduce<string | undefined>(later, undefined);
}

function later(one: string | undefined, other: string): string {
  return one === undefined || Date.parse(other) > Date.parse(one) ? other : one;
}

function beginning(period: Period): string | undefined {
  const seconds = PERIODS[period];
  return seconds === null ? undefined : new Date(Date.now() - seconds * 1000).toISOString();
}

/** Fetches the changes since a time, latest orders first, up to the number shown. */
async function newest(since: string | undefined): Promise<Job[]> {
  const jobs: Job[] = [];
  let cursor: string | undefined;
  do {
    const query = { since, limit: PAGE, cursor, newest_first: true };
    const page: Schema<"Page_Job_"> = await answer(api.GET("/api/v1/jobs", { params: { query } }));
    jobs.push(...page.items);
    cursor = page.next ?? undefined;
  } while (cursor !== undefined && jobs.length < MOST);
  return jobs;
}

function forgetRemoved(client: ReturnType<typeof useQueryClient>, queryKey: readonly unknown[]): () => void {
  return onEvent((event) => {
    if (event.kind !== "job" || event.type !== "Removed") return;
    client.setQueryData<Job[]>(queryKey, (jobs) => jobs?.filter((job) => job.id !== event.subject));
  });
}
