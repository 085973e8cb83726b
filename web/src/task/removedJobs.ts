/** Jobs removed while this page is open: they are not fetched again, and their views close. */

import { create } from "zustand";
import { onEvent, onReset } from "../live/events";
import { useReplay } from "../scene3d/replay";

interface Gone {
  jobs: ReadonlySet<string>;
}

const useGone = create<Gone>(() => ({ jobs: new Set() }));

export function useIsGone(job: string): boolean {
  return useGone(({ jobs }) => jobs.has(job));
}

export function forget(job: string): void {
  useGone.setState(({ jobs }) => ({ jobs: new Set([...jobs, job]) }));
  const { replay, set } = useReplay.getState();
  if (replay?.job === job) set({ replay: null, speed: 0 });
}

/** A new job may reuse the id of a removed one. */
function isThere(job: string): void {
  if (!useGone.getState().jobs.has(job)) return;
  useGone.setState(({ jobs }) => ({ jobs: new Set([...jobs].filter((one) => one !== job)) }));
}

onEvent(({ kind, type, subject }) => {
  if (kind === "job") (type === "Removed" ? forget : isThere)(subject);
});
onReset(() => useGone.setState({ jobs: new Set() }));
