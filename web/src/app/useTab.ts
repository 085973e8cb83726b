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

/** Says what a tab is opened with by who comes back to it; `isOpen` while it is the one that is looked at. */
type Return = (isOpen: boolean) => string;

const returns = new Map<Tab, Return>();

/** Has a tab say itself what to come back to, instead of what was looked at in it last. */
export function comesBackTo(tab: Tab, back: Return): void {
  returns.set(tab, back);
}

/** What to open a tab with by its name alone: what was looked at in it last, or what it says itself. */
function leftAt(tab: Tab, isOpen: boolean): string {
  return returns.get(tab)?.(isOpen) ?? left.get(tab) ?? "";
}

/** Opens a tab as it was left; an address that names nothing in it, as on the way back, is shown as it stands. */
export function useOpenAsLeft(): (tab: Tab) => void {
  const [shown, open] = useTab();
  return (tab) => open(tab, leftAt(tab, tab === shown));
}
