/** A sequence and its edits, each based on the displayed version. */

import { useQuery, useQueryClient } from "@tanstack/react-query";
import { useState } from "react";
import { answer, api, ApiProblem, type Schema } from "../api/client";
import { keys } from "../api/keys";
import { useSingleMutation } from "../api/mutations";
import { notifyProblem } from "../widgets/problems";

export type WantedStep = Schema<"WantedStep">;

export interface Step extends WantedStep {
  arguments: Record<string, string>;
  /** The subsystem that would execute it now; empty if there is none. */
  agent: string;
  works: boolean;
  problems: string[];
}

export interface Sequence {
  id: string;
  title: string;
  version: number;
  count: number;
  /** Whether it has steps, and no step has known problems. */
  works: boolean;
  steps: Step[];
}

/** Content of a sequence document. */
interface Content {
  title?: string;
  steps?: WantedStep[];
}

const KIND = "sequence";

export function sequenceOf({ id, revision, data, problems, agents }: Schema<"DocumentInfo">): Sequence {
  const { title = "", steps = [] } = data as Content;
  const checked = steps.map((step, index) => {
    const place = `steps[${index}]`;
    const wrong = problems.filter((problem) => problem.place === place).map(({ text }) => text);
    const agent = agents[place] ?? "";
    return { ...step, arguments: step.arguments ?? {}, agent, works: wrong.length === 0, problems: wrong };
  });
  const works = steps.length > 0 && problems.length === 0;
  return { id, title, version: revision, count: steps.length, works, steps: checked };
}

export function useSequences() {
  return useQuery({
    queryKey: keys.documents(KIND),
    queryFn: () => answer(api.GET("/api/v1/documents/{kind}", { params: { path: { kind: KIND } } })),
    select: ({ items }) => items.map(sequenceOf),
  });
}

/** Writes a sequence; creates one if no version is given. */
export async function write(id: string, content: Content, version?: number): Promise<Sequence> {
  const header = version === undefined ? {} : { "if-match": `"${version}"` };
  const params = { path: { kind: KIND, id }, header };
  const body = { data: content as Record<string, unknown> };
  return sequenceOf(await answer(api.PUT("/api/v1/documents/{kind}/{id}", { params, body })));
}

export function remove({ id, version }: Sequence): Promise<unknown> {
  const params = { path: { kind: KIND, id }, header: { "if-match": `"${version}"` } };
  return answer(api.DELETE("/api/v1/documents/{kind}/{id}", { params }));
}

export type Edit =
  | { kind: "insert"; at: number; step: WantedStep }
  | { kind: "change"; at: number; step: WantedStep }
  | { kind: "remove"; at: number }
  | { kind: "move"; at: number; to: number }
  /** Undo and redo: all steps as they were. */
  | { kind: "restore"; steps: readonly WantedStep[] };

/** A refused edit, because another person has changed the sequence; shown in the step's form if it has one. */
export interface Conflict {
  edit: Exclude<Edit, { kind: "change" | "restore" }>;
  /** The version on which it was based, and the current one. */
  seen: Sequence;
  there: Sequence;
}

/** Also invalidated by changes of the world, against which each step is checked. */
function keyOf(id: string) {
  return keys.world("sequence", id);
}

export function useSequence(id: string) {
  return useQuery({ queryKey: keyOf(id), queryFn: () => read(id), staleTime: 0 });
}

async function read(id: string): Promise<Sequence> {
  const params = { path: { kind: KIND, id } };
  return sequenceOf(await answer(api.GET("/api/v1/documents/{kind}/{id}", { params })));
}

/** The steps before each edit made here, and after each one that was undone. */
interface Done {
  past: readonly (readonly WantedStep[])[];
  future: readonly (readonly WantedStep[])[];
}

/** @param made - Called with the new version after an edit made here. */
export function useEdits(sequence: Sequence, made: (there: Sequence) => void) {
  const client = useQueryClient();
  const [conflict, setConflict] = useState<Conflict | null>(null);
  const [done, setDone] = useState<Done>({ past: [], future: [] });
  const take = (there: Sequence) => {
    client.setQueryData(keyOf(sequence.id), there);
    void client.invalidateQueries({ queryKey: keys.documents(KIND) });
  };
  const { mutate, isPending } = useSingleMutation({
    mutationFn: (edit: Edit) => {
      const { id, title, version } = sequence;
      return write(id, { title, steps: edited(sequence.steps, edit) }, version);
    },
    onSuccess: (there, edit) => {
      take(there);
      made(there);
      setConflict(null);
      if (edit.kind !== "restore") setDone(({ past }) => ({ past: [...past, sequence.steps], future: [] }));
    },
    onError: async (error, edit) => {
      if (!isConflict(error)) return notifyProblem(error);
      const there = await read(sequence.id);
      take(there);
      if (edit.kind !== "change" && edit.kind !== "restore") setConflict({ edit, seen: sequence, there });
    },
  });
  const go = (steps: readonly WantedStep[] | undefined, then: Done) =>
    steps === undefined ? null : () => mutate({ kind: "restore", steps }, { onSuccess: () => setDone(then) });
  const { past, future } = done;
  const history = {
    undo: go(past.at(-1), { past: past.slice(0, -1), future: [...future, sequence.steps] }),
    redo: go(future.at(-1), { past: [...past, sequence.steps], future: future.slice(0, -1) }),
  };
  return { edit: mutate, isPending, conflict, drop: () => setConflict(null), history };
}

/** Whether another person has changed it meanwhile. */
export function isConflict(error: unknown): boolean {
  return error instanceof ApiProblem && error.status === 412;
}

/** The steps after an edit. */
export function edited(steps: readonly WantedStep[], edit: Edit): WantedStep[] {
  const wanted: WantedStep[] = steps.map(({ skill, arguments: given = {} }) => ({ skill, arguments: given }));
  switch (edit.kind) {
    case "insert":
      return wanted.toSpliced(edit.at, 0, edit.step);
    case "change":
      return wanted.with(edit.at, edit.step);
    case "remove":
      return wanted.toSpliced(edit.at, 1);
    case "restore":
      return [...edit.steps];
    case "move":
      return wanted.toSpliced(edit.at, 1).toSpliced(edit.to, 0, ...wanted.slice(edit.at, edit.at + 1));
  }
}

/** The edit applied to the current version; null if its step has changed. */
export function onto({ edit, seen, there }: Conflict): Conflict["edit"] | null {
  if (edit.kind === "insert") return { ...edit, at: Math.min(edit.at, there.steps.length) };
  const at = sameStep({ seen, at: edit.at }, there);
  if (at === null) return null;
  return edit.kind === "move" ? { ...edit, at, to: Math.min(edit.to, there.steps.length - 1) } : { ...edit, at };
}

/** A step as displayed. */
export interface SeenStep {
  seen: Sequence;
  /** From 0. */
  at: number;
}

/** Present index of an unchanged step; of several, the nearest; null for none. */
function sameStep({ seen, at }: SeenStep, there: Sequence): number | null {
  const meant = seen.steps[at];
  if (meant === undefined) return null;
  const same = there.steps.flatMap((step, index) => (isSame(step, meant) ? [index] : []));
  return same.sort((one, other) => Math.abs(one - at) - Math.abs(other - at))[0] ?? null;
}

/** The change of a step since it was displayed; undecidable changes count as removal. */
export type Fate = { fate: "stays" | "changed"; at: number } | { fate: "removed" };

export function fateOf(step: SeenStep, there: Sequence): Fate {
  if (step.seen.version === there.version) return { fate: "stays", at: step.at };
  const at = sameStep(step, there);
  if (at !== null) return { fate: "stays", at };
  const changed = changedStep(step, there);
  return changed === null ? { fate: "removed" } : { fate: "changed", at: changed };
}

/** Present index of a step between its former neighbours; null if there is none: it was removed. */
function changedStep({ seen, at }: SeenStep, there: Sequence): number | null {
  const follows = (index: number, beside: number) => isSameOrNone(there.steps[index + beside], seen.steps[at + beside]);
  const isNew = (step: WantedStep) => !seen.steps.some((known) => isSame(known, step));
  const found = there.steps.findIndex((step, index) => isNew(step) && follows(index, -1) && follows(index, 1));
  return found === -1 ? null : found;
}

function isSameOrNone(one: WantedStep | undefined, other: WantedStep | undefined): boolean {
  return one === undefined || other === undefined ? one === other : isSame(one, other);
}

function isSame(one: WantedStep, other: WantedStep): boolean {
  return one.skill === other.skill && JSON.stringify(sorted(one)) === JSON.stringify(sorted(other));
}

function sorted(step: WantedStep): [string, string][] {
  return Object.entries(step.arguments ?? {}).sort();
}
