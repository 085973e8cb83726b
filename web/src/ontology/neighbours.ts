/** The classes around a class, few enough to be looked at. */

import type { Schema } from "../api/client";
import type { GraphEdge, GraphNode } from "../widgets/Graph";
import type { Classes } from "../world/classes";
import type { RelationInfo } from "../world/queries";

const MOST = 8; // of each kind

interface Neighbourhood {
  nodes: GraphNode[];
  edges: GraphEdge[];
  /** How many there are besides. */
  left: number;
}

/** Returns parents, those directly below, and the classes that relations lead to, which the relations are told with. */
export function neighbours(
  class_: Pick<Schema<"ClassDetails">, "name" | "parents" | "relations_from">,
  classes: Classes,
  relations: readonly RelationInfo[],
): Neighbourhood {
  const below = classes.get(class_.name)?.children ?? [];
  const targets = targetsOf(class_, relations);
  const reached = [...targets.keys()].filter((name) => name !== class_.name);
  const nodes = new Map<string, GraphNode>();
  const take = (name: string, subtitle: string) => {
    if (!nodes.has(name)) nodes.set(name, { id: name, title: classes.get(name)?.label ?? name, subtitle });
  };
  take(class_.name, class_.name);
  [...class_.parents.slice(0, MOST), ...below.slice(0, MOST)].forEach((name) => take(name, name));
  reached.slice(0, MOST).forEach((name) => take(name, (targets.get(name) ?? []).join(", ")));
  const edges = [
    ...class_.parents.slice(0, MOST).map((name) => ({ from: name, to: class_.name })),
    ...[...below.slice(0, MOST), ...reached.slice(0, MOST)].map((name) => ({ from: class_.name, to: name })),
  ];
  const all = class_.parents.length + below.length + reached.length;
  return { nodes: [...nodes.values()], edges: unique(edges), left: Math.max(0, all - edges.length) };
}

/** Returns the classes that are objects of its relations, each with those relations; computed ones hold of everything. */
function targetsOf(
  { relations_from: from }: { relations_from: readonly string[] },
  relations: readonly RelationInfo[],
) {
  const targets = new Map<string, string[]>();
  for (const { name, computed, family, objects } of relations) {
    if (!from.includes(name) || computed || family === "computed") continue;
    for (const target of objects.flat()) targets.set(target, [...(targets.get(target) ?? []), name]);
  }
  return targets;
}

function unique(edges: readonly GraphEdge[]): GraphEdge[] {
  const seen = new Set<string>();
  return edges.filter(({ from, to }) => {
    const key = [from, to].sort().join(" ");
    return !seen.has(key) && seen.add(key);
  });
}
