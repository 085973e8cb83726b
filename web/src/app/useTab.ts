import { useHashLocation } from "wouter/use-hash-location";
import { addressOf, readAddress, type Tab } from "./address";

export { type Tab, TABS } from "./address";

/** The tab that the address names (`#/task/kit-17`), how to open one, and what the address says behind it. */
export function useTab(): [tab: Tab, open: (tab: Tab, detail?: string) => void, detail: string] {
  const [path, navigate] = useHashLocation();
  const { tab, detail } = readAddress(path);
  return [tab, (next, detail = "") => navigate(addressOf(next, detail)), detail];
}
