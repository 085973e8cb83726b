/** Goal templates: goals with placeholders, which an order fills in. */

import { useQuery } from "@tanstack/react-query";
import { create } from "zustand";
import { answer, api, type Schema } from "../api/client";
import { keys } from "../api/keys";
import { notifyDone } from "../widgets/toasts";
import type { Filled, Piece } from "./draft";
import { type CheckedCondition, type GoalData, type GoalOrder, isWord } from "./goals";
import type { ConditionWord } from "./sentence";

/** Content of a template; its conditions contain placeholders for the names in an order. */
export interface Content {
  description: string;
  parameters: Parameter[];
  goal: GoalData[];
  per_material: GoalData | null;
}

type Parameter = Required<Schema<"TemplateParameter">>;
type GivenParameter = Pick<Parameter, "name"> & Partial<Parameter>;

export interface Template {
  name: string;
  version: number;
  content: Content;
}

const KIND = "template";
export const TEMPLATES = keys.documents(KIND);

export function useTemplates(): readonly Template[] {
  const { data } = useQuery({
    queryKey: TEMPLATES,
    queryFn: () => answer(api.GET("/api/v1/documents/{kind}", { params: { path: { kind: KIND } } })),
    select: ({ items }) => items.map(templateOf),
  });
  return data ?? NONE;
}

function templateOf({ id, revision, data }: Schema<"DocumentInfo">): Template {
  const given = data as Partial<Omit<Content, "parameters">> & { parameters?: GivenParameter[] };
  const parameters = (given.parameters ?? []).map((one) => ({ class: "", default: null, description: "", ...one }));
  const content = { description: "", goal: [], per_material: null, ...given, parameters };
  return { name: id, version: revision, content };
}

/**
 * Creates, replaces or removes a template.
 *
 * @param seen - The version that was displayed; null if there was none.
 * @param content - The new content; null to remove it.
 * @returns A function that undoes the change, and returns one that does it again.
 */
export async function changeTemplate(name: string, seen: Template | null, content: Content | null): Promise<Undo> {
  const header = seen ? { "if-match": `"${seen.version}"` } : {};
  const params = { path: { kind: KIND, id: name }, header };
  const now =
    content === null
      ? await answer(api.DELETE("/api/v1/documents/{kind}/{id}", { params })).then(() => null)
      : templateOf(await answer(api.PUT("/api/v1/documents/{kind}/{id}", { params, body: { data: { ...content } } })));
  if (now) written.set(name, now.version);
  return () =>
    changeTemplate(name, now && { ...now, version: written.get(name) ?? now.version }, seen?.content ?? null);
}

/** The versions written here last, by name: undoing writes new ones. */
const written = new Map<string, number>();

type Undo = () => Promise<Undo>;

interface Changes {
  /** How many changes are in effect. */
  count: number;
  /** For each change what takes it back; once taken back, what makes it again. */
  reverse: readonly Undo[];
}

/** The changes of templates made here, for the history of the tab. */
export const useTemplateChanges = create<Changes>(() => ({ count: 0, reverse: [] }));

/** Reports a change of templates, and adds it to the history. */
export function notifyTemplate(message: string, undo: Undo): void {
  useTemplateChanges.setState(({ count, reverse }) => ({
    count: count + 1,
    reverse: [...reverse.slice(0, count), undo],
  }));
  notifyDone(message);
}

/** Takes back the last change that is in effect, or makes the next one again; `count` will be in effect then. */
export async function reverseTemplate(count: number): Promise<void> {
  const { count: before, reverse } = useTemplateChanges.getState();
  const last = Math.min(count, before);
  const back = count === before ? undefined : await reverse[last]?.();
  if (back) useTemplateChanges.setState({ reverse: reverse.map((one, at) => (at === last ? back : one)) });
}

const NONE: readonly Template[] = [];

/** The fields of a material, in the order of the table's columns. */
export const FIELDS = ["class", "location", "id", "definition", "lot", "use"] as const;
export type Field = (typeof FIELDS)[number];

export const EMPTY: Piece = { class: "", quantity: 1, id: "", location: "", use: "", definition: "", lot: "" };

/** The fields of materials that a template uses; always includes the class. */
export function fieldsOf({ per_material: each }: Content): Field[] {
  const json = JSON.stringify(each ?? null);
  return FIELDS.filter((field) => field === "class" || json.includes(JSON.stringify({ material: field })));
}

/** Whether rows may have a quantity: if pieces are told apart, each needs its own row. */
export function isCounted(fields: readonly Field[]): boolean {
  return !fields.includes("location") && !fields.includes("id");
}

/** The order of a filled-in template; null while it is incomplete. Rows without a part are ignored. */
export function templateOrder(filled: Filled, content: Content): GoalOrder | null {
  const given = content.parameters.filter(({ name }) => filled.parameters[name]);
  const missing = content.parameters.some(({ name, default: fallback }) => !filled.parameters[name] && !fallback);
  const fields = fieldsOf(content);
  const materials = content.per_material ? filled.materials.filter((piece) => piece.class !== "") : [];
  const incomplete = materials.some((piece) => fields.some((field) => !piece[field]));
  if (missing || incomplete || (content.per_material && materials.length === 0)) return null;
  const parameters = Object.fromEntries(given.map(({ name }) => [name, filled.parameters[name] ?? ""]));
  return { work_master: filled.name, parameters, materials: materials.map((piece) => ({ ...piece, units: "" })) };
}

/** The class of a placeholder, derived from the word that contains it. */
export function classOf(content: Content, placeholder: GoalData, words: readonly ConditionWord[]): string | undefined {
  const wanted = JSON.stringify(placeholder);
  for (const data of inner([...content.goal, content.per_material])) {
    const at = data.arguments.findIndex((argument) => JSON.stringify(argument) === wanted);
    const role = words.find(({ name }) => name === data.condition)?.roles[at];
    if (role) return role.class;
  }
  return undefined;
}

interface Said {
  condition: string;
  arguments: unknown[];
}

/** All words in structured conditions, at any depth. */
function inner(data: unknown): Said[] {
  if (typeof data !== "object" || data === null) return [];
  if ("condition" in data && "arguments" in data && Array.isArray(data.arguments)) return [data as Said];
  return Object.values(data).flatMap(inner);
}

/** An element of the conditions that can become a parameter: its id and the proposed name. */
export interface Variable {
  id: string;
  name: string;
  class: string;
}

/** The elements named in the conditions, without duplicates, with parameter names derived from their roles. */
export function variablesOf(conditions: readonly CheckedCondition[], words: readonly ConditionWord[]): Variable[] {
  const found = new Map<string, Variable>();
  for (const word of inner(conditions.map(({ data }) => data))) {
    if (!isWord(word)) continue;
    const roles = words.find(({ name }) => name === word.condition)?.roles ?? [];
    for (const [index, id] of word.arguments.entries()) {
      const role = roles[index];
      if (role === undefined || id.includes(":") || found.has(id)) continue;
      const taken = [...found.values()].filter(({ name }) => name.replace(/_\d+$/, "") === role.name).length;
      found.set(id, { id, name: taken === 0 ? role.name : `${role.name}_${taken + 1}`, class: role.class });
    }
  }
  return [...found.values()];
}

/** Replaces the names that become parameters with placeholders. */
export function withPlaceholders(data: unknown, variables: readonly Variable[]): unknown {
  if (Array.isArray(data)) return data.map((one) => withPlaceholders(one, variables));
  if (typeof data === "object" && data !== null)
    return Object.fromEntries(
      Object.entries(data).map(([key, one]) => [
        key,
        key === "arguments" ? named(one, variables) : withPlaceholders(one, variables),
      ]),
    );
  return data;
}

function named(names: unknown, variables: readonly Variable[]): unknown {
  if (!Array.isArray(names)) return names;
  return names.map((name) => {
    const variable = variables.find(({ id }) => id === name);
    return variable ? { parameter: variable.name } : name;
  });
}

/** Whether a template may have this name, which is part of its address: "/" and names of only dots would break it. */
export function isTemplateName(name: string): boolean {
  return !name.includes("/") && !/^\.{1,2}$/.test(name.trim());
}
