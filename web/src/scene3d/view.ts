/** The visible world, kept up to date by events: only what they name is read again. */

import { create } from "zustand";
import { answer, api, type Schema } from "../api/client";
import { type EventInfo, onEvent, onReset } from "../live/events";

export type ViewElement = Schema<"ViewElement">;
export type Block = Schema<"Block">;
export type WorldView = Schema<"WorldView">;

/** A world as it looks at one moment. */
export interface View {
  version: number;
  elements: ReadonlyMap<string, ViewElement>;
  shapes: Readonly<Record<string, readonly Block[]>>;
}

interface Live {
  view: View | null;
  /** Why it cannot be read; null while it can. */
  problem: unknown;
}

/** The present, also while a replay is shown. */
export const useLiveView = create<Live>(() => ({ view: null, problem: null }));

const PAUSE = 100; // ms between two readings
const FIRST = 15; // ms: what happens at once is read at once
const AGAIN = 1000; // ms
const MOST = 100; // ids in one address

export function viewFrom(told: WorldView): View {
  return {
    version: told.version,
    elements: new Map(told.elements.map((element) => [element.id, element])),
    shapes: told.shapes,
  };
}

/** The view with what was read again; the view before is not changed. */
export function merged(view: View, told: WorldView): View {
  const elements = new Map(view.elements);
  for (const id of told.gone) elements.delete(id);
  for (const element of told.elements) elements.set(element.id, element);
  return { version: told.version, elements, shapes: { ...view.shapes, ...told.shapes } };
}

/** Which elements an event makes old: their ids, "all", or none. */
export function madeOld(event: EventInfo): "all" | readonly string[] {
  if (event.kind === "system") return event.type === "opened" ? "all" : [];
  if (event.kind !== "world") return [];
  const { edits, all_edits: more } = event.data as { edits?: Record<string, unknown>[]; all_edits?: number };
  if (edits === undefined || more !== undefined) return "all";
  const named = edits.flatMap((edit) => [edit["element"], edit["subject"], edit["object"]]);
  const ids = [...new Set(named.filter((id) => typeof id === "string"))];
  return ids.length > MOST ? "all" : ids;
}

/** Reads the world and follows it; returns how to end that. */
export function followView(): () => void {
  const reader = new Reader();
  const endings = [onEvent((event) => reader.ask(madeOld(event))), onReset(() => reader.ask("all"))];
  reader.ask("all");
  return () => {
    reader.end();
    for (const end of endings) end();
  };
}

/** Reads one thing after the other, so that nothing older comes after what is newer. */
class Reader {
  private readonly ids = new Set<string>();
  private all = false;
  private busy = false;
  private ended = false;
  private next = 0; // ms, when it may read again
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
      const told = (await answer(api.GET("/api/v1/view", { params: { query: { element: ids } } }))) as WorldView;
      if (this.ended) return true;
      const { view } = useLiveView.getState();
      const whole = ids === undefined || view === null;
      useLiveView.setState({ view: whole ? viewFrom(told) : merged(view, told), problem: null });
      return true;
    } catch (problem) {
      useLiveView.setState({ problem });
      return false;
    }
  }
}
