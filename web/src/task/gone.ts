/** Jobs that were removed while this page was open: they are not read again, and views of them end. */

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

/** Another job may get the id of one that was removed. */
function isThere(job: string): void {
  if (!useGone.getState().jobs.has(job)) return;
  useGone.setState(({ jobs }) => ({ jobs: new Set([...jobs].filter((one) => one !== job)) }));
}

onEvent(({ kind, type, subject }) => {
  if (kind === "job") (type === "Removed" ? forget : isThere)(subject);
});
onReset(() => useGone.setState({ jobs: new Set() }));
