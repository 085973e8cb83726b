/** Unfinished arguments by module, kept while other tabs are shown. */

import { create } from "zustand";
import type { Arguments } from "../widgets/ArgumentsForm";

export interface Draft {
  values: Arguments;
  repeat: number;
}

interface Drafts {
  drafts: Readonly<Record<string, Draft>>;
  /** Sets the unfinished arguments of a module of a subsystem. */
  put: (key: string, draft: Draft) => void;
}

const EMPTY: Draft = { values: {}, repeat: 1 };

const useDrafts = create<Drafts>((set) => ({
  drafts: {},
  put: (key, draft) => set(({ drafts }) => ({ drafts: { ...drafts, [key]: draft } })),
}));

export function useDraft(agent: string, module: string) {
  const key = `${agent}/${module}`;
  const draft = useDrafts((all) => all.drafts[key] ?? EMPTY);
  const put = useDrafts((all) => all.put);
  return [draft, (change: Partial<Draft>) => put(key, { ...draft, ...change })] as const;
}
