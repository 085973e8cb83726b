import { useHashLocation } from "wouter/use-hash-location";
import { addressOf, readAddress, type Tab } from "./address";

export { type Tab, TABS } from "./address";

/** The tab in the address (`#/task/kit-17`), the rest of the address, and how to open a tab. */
export function useTab(): [tab: Tab, open: (tab: Tab, detail?: string) => void, detail: string] {
  const [path, navigate] = useHashLocation();
  const { tab, detail } = readAddress(path);
  return [tab, (next, detail = "") => navigate(addressOf(next, detail)), detail];
}

const left = new Map<Tab, string>();

/** Remembers the content of a tab until it is opened again. */
export function leave(tab: Tab, detail: string): void {
  left.set(tab, detail);
}

/** Returns the content with which a tab opens; `isOpen` while it is the open tab. */
type Return = (isOpen: boolean) => string;

const returns = new Map<Tab, Return>();

/** Lets a tab define the content to return to, instead of the last one. */
export function comesBackTo(tab: Tab, back: Return): void {
  returns.set(tab, back);
}

/** The content with which a tab opens by its name alone: the last one, or the one the tab defines. */
function leftAt(tab: Tab, isOpen: boolean): string {
  return returns.get(tab)?.(isOpen) ?? left.get(tab) ?? "";
}

/** Opens a tab with its content; an address without content, for example after going back, is shown as it is. */
export function useOpenAsLeft(): (tab: Tab) => void {
  const [shown, open] = useTab();
  return (tab) => open(tab, leftAt(tab, tab === shown));
}
