import { useHashLocation } from "wouter/use-hash-location";
import { addressOf, readAddress, type Tab } from "./address";

export { type Tab, TABS } from "./address";

/** The tab that the address names (`#/task/kit-17`), how to open one, and what the address says behind it. */
export function useTab(): [tab: Tab, open: (tab: Tab, detail?: string) => void, detail: string] {
  const [path, navigate] = useHashLocation();
  const { tab, detail } = readAddress(path);
  return [tab, (next, detail = "") => navigate(addressOf(next, detail)), detail];
}

const left = new Map<Tab, string>();

/** Remembers what is looked at in a tab, until it is opened again. */
export function leave(tab: Tab, detail: string): void {
  left.set(tab, detail);
}

/** What was looked at in a tab last. The Task tab knows itself: there, what has begun meanwhile comes first. */
export function leftAt(tab: Tab): string {
  return tab === "task" ? "" : (left.get(tab) ?? "");
}
