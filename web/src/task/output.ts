/** The latest messages of modules: fetched once, then followed while they are shown. */

import { create } from "zustand";
import { answer, api } from "../api/client";
import { type EventInfo, onEvent, onReset } from "../live/events";

/** One message of a module (the paper's fields, and its origin). */
export interface OutputRow {
  /** Unique id, which begins with the id of the server's run. */
  id: string;
  /** Run time [s]. */
  time: number;
  /** Wall time [ms since 1970]. */
  at: number;
  module: string;
  kind: string;
  /** started, running, paused, resumed, preempted, terminated or error. */
  status: string;
  code: number;
  text: string;
  agent: string;
  /** The parent module; empty for the one that was started. */
  caller: string;
  /** Label of the skill's implementation; null for primitives, and if unknown. */
  implementation: string | null;
  /** Id of its run. */
  run: string;
  /** Id of the outermost run: the step of a task, or a single module. */
  root: string;
  /** Path of its node: the started module, and the keys down to the node. */
  path: string;
}

interface Output {
  rows: readonly OutputRow[];
  failed: unknown;
}

export const MOST_ROWS = 2000;
const PAGE = 1000;
const LOOKED_BACK = 4000; // events of all kinds
const PAUSE = 200; // ms: faster than people can read

export const useOutput = create<Output>(() => ({ rows: [], failed: null }));

export function rowOf(event: EventInfo): OutputRow {
  const { kind, code, text, agent, caller, implementation, run, root, path } = event.data;
  return {
    id: event.id,
    time: event.time,
    at: Date.parse(event.at),
    module: event.subject,
    kind: String(kind ?? ""),
    status: event.type,
    code: typeof code === "number" ? code : 0,
    text: String(text ?? ""),
    agent: String(agent ?? ""),
    caller: String(caller ?? ""),
    implementation: typeof implementation === "string" ? implementation : null,
    run: String(run ?? ""),
    root: String(root ?? ""),
    path: String(path ?? ""),
  };
}

/** Inserts new rows in order, and drops the oldest if there are too many. */
export function added(rows: readonly OutputRow[], more: readonly OutputRow[]): readonly OutputRow[] {
  const known = new Set(rows.map((row) => row.id));
  const fresh = more.filter((row) => !known.has(row.id));
  if (fresh.length === 0) return rows;
  return [...rows, ...fresh].sort((one, other) => one.at - other.at || number(one) - number(other)).slice(-MOST_ROWS);
}

function number(row: OutputRow): number {
  return Number(row.id.slice(row.id.lastIndexOf("-") + 1));
}

let followers = 0;
let end: (() => void) | undefined;

/** Follows the messages of modules until the returned function is called. */
export function followOutput(): () => void {
  followers += 1;
  if (followers === 1) end = begin();
  return () => {
    followers -= 1;
    if (followers === 0) end?.();
  };
}

function begin(): () => void {
  let waiting: OutputRow[] = [];
  let timer: ReturnType<typeof setTimeout> | undefined;
  const flush = () => {
    timer = undefined;
    const more = waiting;
    waiting = [];
    useOutput.setState(({ rows }) => ({ rows: added(rows, more), failed: null }));
  };
  const take = (more: readonly OutputRow[]) => {
    waiting.push(...more);
    timer ??= setTimeout(flush, PAUSE);
  };
  const read = () => {
    recent().then(take, (failed: unknown) => useOutput.setState({ failed }));
  };
  read();
  const ends = [onEvent((event) => event.kind === "module" && take([rowOf(event)])), onReset(read)];
  return () => {
    clearTimeout(timer);
    for (const one of ends) one();
  };
}

async function recent(): Promise<OutputRow[]> {
  return (await since(await somewhatBefore())) ?? (await since(undefined)) ?? [];
}

/** Fetches the events after a position; null if some of them are no longer kept. */
async function since(place: string | undefined): Promise<OutputRow[] | null> {
  const rows: OutputRow[] = [];
  let after = place;
  for (;;) {
    const query = { kind: ["module" as const], after, limit: PAGE };
    const page = await answer(api.GET("/api/v1/events/recent", { params: { query } }));
    if (page.reset != null) return null;
    rows.push(...page.items.map(rowOf));
    if (page.items.length < PAGE) return rows;
    after = page.next;
  }
}

/** A recent position: a request for events after an unknown id is answered with the end of the log. */
async function somewhatBefore(): Promise<string | undefined> {
  const page = await answer(api.GET("/api/v1/events/recent", { params: { query: { after: "unknown", limit: 1 } } }));
  const end = page.reset?.id ?? page.next;
  const cut = end.lastIndexOf("-");
  const place = Number(end.slice(cut + 1)) - LOOKED_BACK;
  return place > 0 ? `${end.slice(0, cut)}-${place}` : undefined;
}
