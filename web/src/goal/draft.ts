/** The goal being edited: survives changes of the tab and reloads, one for each scene. */

import { useQuery } from "@tanstack/react-query";
import { create } from "zustand";
import { createJSONStorage, persist } from "zustand/middleware";
import { answer, api, type Schema } from "../api/client";
import { keys } from "../api/keys";
import { type NewRow, type Row, keyed } from "./goals";

export interface Filled {
  /** Name of the goal template. */
  name: string;
  parameters: Record<string, string>;
  materials: Piece[];
}

/** A row of the bill of parts; all fields are texts, empty for "any". */
export interface Piece {
  class: string;
  quantity: number;
  id: string;
  location: string;
  use: string;
  definition: string;
  lot: string;
}

export interface Options {
  description: string;
  priority: number;
  policy: Schema<"JobPolicy">;
}

export interface Draft {
  rows: Row[];
  /** The goal template used instead of the rows; null for none. */
  template: Filled | null;
  options: Options;
  /** The kit whose places are shown as a table; null for none. */
  kit: string | null;
  /** The last requested plan: its id, the order it is for, and the time (ids restart with the server). */
  preview: { id: string; asked: string; order: string } | null;
  /** An order being sent: repeated under the same key, it creates no second job. */
  pending: { key: string; body: string } | null;
  /** Id of the last ordered job. */
  job: string | null;
}

export const NEW: Draft = {
  rows: [],
  template: null,
  options: {
    description: "",
    priority: 0,
    policy: { rest: true, ask: false, attempts: 3, partial: false, rehearse: false },
  },
  kit: null,
  preview: null,
  pending: null,
  job: null,
};

type Change = Partial<Draft> | ((draft: Draft) => Partial<Draft>);

interface Drafts {
  drafts: Record<string, Draft>;
  change: (scene: string, change: Change) => void;
}

export const useDrafts = create<Drafts>()(
  persist(
    (set) => ({
      drafts: {},
      change: (scene, change) =>
        set(({ drafts }) => {
          const draft = { ...NEW, ...drafts[scene] };
          return {
            drafts: { ...drafts, [scene]: { ...draft, ...(change instanceof Function ? change(draft) : change) } },
          };
        }),
    }),
    { name: "skiros-goals", version: 1, storage: createJSONStorage(() => sessionStorage) },
  ),
);

/** The name of the current scene; undefined until it is known. */
export function useSceneName(): string | undefined {
  const { data } = useQuery({
    queryKey: keys.station("scene"), // not "scenes", which every change of the world invalidates
    queryFn: () => answer(api.GET("/api/v1/scene")),
  });
  return data?.name;
}

/** The draft of the current scene, and a function to change it. */
export function useDraft() {
  const scene = useSceneName() ?? "";
  const draft = useDrafts(({ drafts }) => drafts[scene]) ?? NEW;
  const change = (next: Change) => useDrafts.getState().change(scene, next);
  return {
    draft,
    /** The current draft, which may be newer than the rendered one. */
    present: () => useDrafts.getState().drafts[scene] ?? NEW,
    change,
    addRows: (rows: readonly NewRow[]) => change((now) => ({ rows: [...now.rows, ...keyed(rows)] })),
    setRows: (rows: readonly NewRow[]) => change({ rows: keyed(rows), template: null }),
    setRow: (row: Row) => change((now) => ({ rows: now.rows.map((one) => (one.key === row.key ? row : one)) })),
    removeRow: (key: string) => change((now) => ({ rows: now.rows.filter((one) => one.key !== key) })),
  };
}

/** Whether a draft still has the goals from which a result was made. */
export function isUntouched(before: Draft | undefined, now: Draft): boolean {
  return before?.rows === now.rows && before.template === now.template;
}
