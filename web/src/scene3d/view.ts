/** The visible world, updated by events: only elements named in them are fetched again. */

import { create } from "zustand";
import { answer, api, type Schema } from "../api/client";
import { type EventInfo, onEvent, onReset } from "../live/events";

export type ViewElement = Schema<"ViewElement">;
export type Block = Schema<"Block">;
export type WorldView = Schema<"WorldView">;

/** The appearance of a world at one time. */
export interface View {
  version: number;
  elements: ReadonlyMap<string, ViewElement>;
  shapes: Readonly<Record<string, readonly Block[]>>;
}

interface Live {
  view: View | null;
  /** Why it cannot be fetched; null without a fault. */
  problem: unknown;
}

/** The present, even while a replay is shown. */
export const useLiveView = create<Live>(() => ({ view: null, problem: null }));

const PAUSE = 100; // ms between two requests
const FIRST = 15; // ms: collects simultaneous changes
const AGAIN = 1000; // ms
const MOST = 100; // ids in one URL

export function viewFrom(fetched: WorldView): View {
  return {
    version: fetched.version,
    elements: new Map(fetched.elements.map((element) => [element.id, element])),
    shapes: fetched.shapes,
  };
}

/** The view merged with fetched elements; the previous view is not modified. */
export function merged(view: View, fetched: WorldView): View {
  const elements = new Map(view.elements);
  for (const id of fetched.gone) elements.delete(id);
  for (const element of fetched.elements) elements.set(element.id, element);
  return { version: fetched.version, elements, shapes: { ...view.shapes, ...fetched.shapes } };
}

/** The elements to fetch after an event: their ids, "all", or none. */
export function madeOld(event: EventInfo): "all" | readonly string[] {
  if (event.kind === "system") return event.type === "opened" ? "all" : [];
  if (event.kind !== "world") return [];
  const { edits, all_edits: more } = event.data as { edits?: Record<string, unknown>[]; all_edits?: number };
  if (edits === undefined || more !== undefined) return "all";
  const named = edits.flatMap((edit) => [edit["element"], edit["subject"], edit["object"]]);
  const ids = [...new Set(named.filter((id) => typeof id === "string"))];
  return ids.length > MOST ? "all" : ids;
}

/** Fetches the world and follows it; returns the function that stops it. */
export function followView(): () => void {
  const reader = new Reader();
  const endings = [onEvent((event) => reader.ask(madeOld(event))), onReset(() => reader.ask("all"))];
  reader.ask("all");
  return () => {
    reader.end();
    for (const end of endings) end();
  };
}

/** Sends one request at a time, so that older answers cannot overwrite newer ones. */
class Reader {
  private readonly ids = new Set<string>();
  private all = false;
  private busy = false;
  private ended = false;
  private next = 0; // ms, earliest time of the next request
  private timer: ReturnType<typeof setTimeout> | undefined;

  ask(old: "all" | readonly string[]): void {
    if (old === "all") this.all = true;
    else for (const id of old) this.ids.add(id);
    this.plan(FIRST);
  }

  end(): void {
    this.ended = true;
    clearTimeout(this.timer);
  }

  private plan(soonest: number): void {
    if (this.busy || this.ended || (!this.all && this.ids.size === 0)) return;
    this.timer ??= setTimeout(() => void this.read(), Math.max(soonest, this.next - performance.now()));
  }

  private async read(): Promise<void> {
    const ids = this.all || this.ids.size > MOST ? undefined : [...this.ids];
    this.all = false;
    this.ids.clear();
    this.timer = undefined;
    this.busy = true;
    this.next = performance.now() + PAUSE;
    const good = await this.take(ids);
    this.busy = false;
    if (!good) this.all = true;
    this.plan(good ? FIRST : AGAIN);
  }

  private async take(ids: string[] | undefined): Promise<boolean> {
    try {
      const fetched = (await answer(api.GET("/api/v1/view", { params: { query: { element: ids } } }))) as WorldView;
      if (this.ended) return true;
      const { view } = useLiveView.getState();
      const whole = ids === undefined || view === null;
      useLiveView.setState({ view: whole ? viewFrom(fetched) : merged(view, fetched), problem: null });
      return true;
    } catch (problem) {
      useLiveView.setState({ problem });
      return false;
    }
  }
}
