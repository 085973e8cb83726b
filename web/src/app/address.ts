/** Addresses within the pages: `/task/kit-17` is the task tab with job kit-17. */

export const TABS = ["goal", "task", "modules", "world"] as const;
export type Tab = (typeof TABS)[number];

export function addressOf(tab: Tab, detail: string): string {
  return detail ? `/${tab}/${encodeURIComponent(detail)}` : `/${tab}`;
}

/** Parses an address that may have been typed by a person; malformed parts are used literally. */
export function readAddress(path: string): { tab: Tab; detail: string } {
  const [, name = "", ...rest] = path.split("/");
  return { tab: TABS.find((known) => known === name) ?? "goal", detail: decoded(rest.join("/")) };
}

function decoded(text: string): string {
  try {
    return decodeURIComponent(text);
  } catch {
    return text; // a "%" that encodes nothing
  }
}
