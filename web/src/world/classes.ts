/** The classes of the ontology, by name. */

import { useQuery } from "@tanstack/react-query";
import type { Schema } from "../api/client";
import { classTree } from "../widgets/names";

type ClassNode = Schema<"ClassNode">;

export interface ClassInfo {
  name: string;
  label: string;
  comment: string;
  parents: readonly string[];
  /** Classes with this one as primary parent. */
  children: readonly string[];
  instances: number;
}

export type Classes = ReadonlyMap<string, ClassInfo>;

export const EVERYTHING = "sk:Element";

const NONE: Classes = new Map();

export function classesOf(top: ClassNode): Classes {
  const found = new Map<string, ClassInfo>();
  const take = (node: ClassNode) => {
    const { name, label, comment, parents, instances } = node;
    found.set(name, { name, label, comment, parents, instances, children: node.children.map((child) => child.name) });
    node.children.forEach(take);
  };
  take(top);
  return found;
}

/** Returns a class and its ancestors, nearest first. */
export function ancestors(classes: Classes, name: string): string[] {
  const found = new Set([name]);
  for (const one of found) classes.get(one)?.parents.forEach((parent) => found.add(parent));
  return [...found];
}

export function useClasses(): Classes {
  const { data } = useQuery({ ...classTree(EVERYTHING), select: classesOf });
  return data ?? NONE;
}
