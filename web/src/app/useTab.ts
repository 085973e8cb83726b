import { useHashLocation } from "wouter/use-hash-location";

export const TABS = ["goal", "task", "modules", "world"] as const;
export type Tab = (typeof TABS)[number];

/** The tab that the address names (`#/task/kit-17`), how to open one, and what the address says behind it. */
export function useTab(): [tab: Tab, open: (tab: Tab, detail?: string) => void, detail: string] {
  const [path, navigate] = useHashLocation();
  const [, name = "", ...rest] = path.split("/");
  const tab = TABS.find((known) => known === name) ?? "goal";
  const open = (next: Tab, detail = "") => navigate(detail ? `/${next}/${encodeURIComponent(detail)}` : `/${next}`);
  return [tab, open, decodeURIComponent(rest.join("/"))];
}
