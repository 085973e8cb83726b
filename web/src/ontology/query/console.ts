/** Helpers of the console: where an error is, what was asked before, rows as links. */

const REMEMBERED = "skiros-queries";
const MOST = 20;

/** Returns the place in a question of which an error speaks; lines and columns count from 1. */
export function placeOf(detail: string): { line: number; column: number } | null {
  const found = /line (\d+)(?:,?\s*(?:column|col)\s*(\d+))?/i.exec(detail) ?? /at (\d+):(\d+)/.exec(detail);
  if (found === null) return null;
  return { line: Number(found[1]), column: Number(found[2] ?? 1) };
}

/** Questions that were asked in this browser, the latest first. */
export function history(): string[] {
  try {
    const kept: unknown = JSON.parse(localStorage.getItem(REMEMBERED) ?? "[]");
    return Array.isArray(kept) ? kept.filter((one) => typeof one === "string") : [];
  } catch {
    return []; // somebody else wrote there
  }
}

export function remember(query: string): string[] {
  const kept = [query, ...history().filter((one) => one !== query)].slice(0, MOST);
  localStorage.setItem(REMEMBERED, JSON.stringify(kept));
  return kept;
}
