/** Helpers of the query console: position of errors, history, sorting of rows. */

import { byName } from "../../widgets/names";

const REMEMBERED = "skiros-queries";
const MOST = 20;

/** Returns the position in the query to which an error refers; lines and columns start at 1. */
export function placeOf(detail: string): { line: number; column: number } | null {
  const found = /line (\d+)(?:,?\s*(?:column|col)\s*(\d+))?/i.exec(detail) ?? /at (\d+):(\d+)/.exec(detail);
  if (found === null) return null;
  return { line: Number(found[1]), column: Number(found[2] ?? 1) };
}

/**
 * Names of an answer's columns in the order in which the query mentions them.
 *
 * The server chooses the order for `SELECT *`; users expect that of the query.
 */
export function columns(query: string, variables: readonly string[]): string[] {
  const at = (name: string) => {
    const found = query.search(new RegExp(`[?$]${name}\\b`));
    return found < 0 ? query.length : found;
  };
  return /select\s+((distinct|reduced)\s+)?\*/i.test(query)
    ? variables.toSorted((one, other) => at(one) - at(other))
    : [...variables];
}

/** Rows sorted by a column, numbers by value; without a column, in the original order. */
export function sorted<Row extends Record<string, unknown>>(rows: readonly Row[], by: Order | null): readonly Row[] {
  if (by === null) return rows;
  const compare = (one: Row, other: Row) => compared(one[by.column], other[by.column]);
  return rows.toSorted(by.falling ? (one, other) => compare(other, one) : compare);
}

export interface Order {
  column: string;
  falling: boolean;
}

function compared(one: unknown, other: unknown): number {
  if (typeof one === "number" && typeof other === "number") return one - other;
  return byName(textOf(one), textOf(other));
}

function textOf(value: unknown): string {
  return typeof value === "string" ? value : JSON.stringify(value ?? "");
}

/** The queries asked in this browser, latest first. */
export function history(): string[] {
  try {
    const kept: unknown = JSON.parse(localStorage.getItem(REMEMBERED) ?? "[]");
    return Array.isArray(kept) ? kept.filter((one) => typeof one === "string") : [];
  } catch {
    return []; // written by another program
  }
}

export function remember(query: string): string[] {
  const kept = [query, ...history().filter((one) => one !== query)].slice(0, MOST);
  localStorage.setItem(REMEMBERED, JSON.stringify(kept));
  return kept;
}
