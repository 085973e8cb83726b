/** Names of elements and classes for people, short but unambiguous. */

import { useQuery } from "@tanstack/react-query";
import { answer, api, type Schema } from "../api/client";
import { keys } from "../api/keys";
import i18n from "../i18n";
import { isolated } from "../i18n/isolated";
import { useLiveView } from "../scene3d/view";

export type ClassNode = Schema<"ClassNode">;

/** Returns a name without prefix: "Starter" for "kitting:Starter". */
export function localName(name: string): string {
  return name.slice(name.lastIndexOf(":") + 1);
}

/** Orders names as people count: part_2 before part_10. */
export const byName = new Intl.Collator(undefined, { numeric: true }).compare;

/** Names without the words with which all of them begin: "joint1" for "panda_joint1". */
export function withoutCommon(names: readonly string[]): string[] {
  const [first = ""] = names;
  const words = [...first.matchAll(/_/g)].map(({ index }) => index + 1);
  const common = words.findLast((end) =>
    names.every((name) => name.length > end && name.startsWith(first.slice(0, end))),
  );
  return names.map((name) => name.slice(names.length > 1 ? (common ?? 0) : 0));
}

/** Joins label and id without repetition: "pallet A", "relay_box_2", "compartment A (kit_1_a)". */
export function nameOf(id: string, label: string): string {
  const said = spelt(label);
  const meant = spelt(localName(id));
  if (said === meant) return isolated(label);
  return said === "" || said === meant.replace(/_\d+$/, "") ? isolated(id) : `${isolated(label)} (${isolated(id)})`;
}

/** The name of an element as the 3D view knows it. */
export function nameNow(id: string): string {
  return nameOf(id, useLiveView.getState().view?.elements.get(id)?.label ?? "");
}

/** A relation or property in words: "held by" for "sk:heldBy"; names without a translation are spaced. */
export function spoken(term: string): string {
  const terms: Record<string, string> = i18n.t("terms", { returnObjects: true });
  const name = localName(term);
  return (
    terms[name] ?? name.replaceAll(/([a-z])([A-Z])/g, (_, end: string, next: string) => `${end} ${next.toLowerCase()}`)
  );
}

function spelt(text: string): string {
  return text
    .trim()
    .replaceAll(/([a-z])([A-Z])/g, "$1_$2")
    .replaceAll(/\s+/g, "_")
    .toLowerCase();
}

/** A class and its subclasses as a list, the class first. */
export function classesOf(root: ClassNode): ClassNode[] {
  return [root, ...root.children.flatMap(classesOf)];
}

const WHOLE = 50; // levels

/** A class with all its subclasses. */
export function classTree(class_: string) {
  return {
    queryKey: keys.ontology("classes", class_),
    queryFn: () => answer(api.GET("/api/v1/ontology/classes", { params: { query: { root: class_, depth: WHOLE } } })),
  };
}

const ELEMENT = "sk:Element";

/** The labels of all classes by name, also without prefix, as in conditions; empty until they are known. */
export function useClassLabels(): ReadonlyMap<string, string> {
  const { data } = useQuery({ ...classTree(ELEMENT), select: labelsOf });
  return data ?? NONE;
}

const NONE: ReadonlyMap<string, string> = new Map();

function labelsOf(root: ClassNode): ReadonlyMap<string, string> {
  const classes = classesOf(root).map(({ name, label }): [string, string] => [name, label]);
  return new Map([...classes, ...classes.map(([name, label]): [string, string] => [localName(name), label])]);
}

/** The name of an element; its id until its label is known. Null for a class or no element. */
export function useElementName(id: string | null): string | null {
  const labels = useClassLabels();
  const wanted = id !== null && id !== "" && !labels.has(id);
  const { data } = useQuery({
    queryKey: keys.names(id),
    queryFn: () => answer(api.GET("/api/v1/elements/{element}", { params: { path: { element: id ?? "" } } })),
    enabled: wanted && labels.size > 0,
    retry: false,
    select: ({ label }) => label,
  });
  if (!wanted) return null;
  return data === undefined ? id : nameOf(id, data);
}
