/** The neighbours of a class, few enough for a readable graph. */

import type { Schema } from "../api/client";
import type { GraphEdge, GraphNode } from "../widgets/Graph";
import type { Classes } from "../world/classes";
import type { RelationInfo } from "../world/queries";

const MOST = 8; // of each kind

interface Neighbourhood {
  nodes: GraphNode[];
  edges: GraphEdge[];
  /** The number of those not drawn. */
  left: number;
}

/** Returns parents, direct subclasses, and the object classes of relations with those relations. */
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

/** Returns the object classes of its relations, with those relations; omits computed ones, which hold everywhere. */
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
