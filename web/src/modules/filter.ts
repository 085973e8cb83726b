/** Filters the list of modules. */

import type { Summary } from "./queries";
import { byName } from "../widgets/names";

export interface Filter {
  text: string;
  kind: "all" | Summary["kind"];
  /** Id of a robot; empty for all. */
  robot: string;
}

export const EVERYTHING: Filter = { text: "", kind: "all", robot: "" };

/** Returns the matching modules, skills first; all words must occur in name, help or names of subsystems. */
export function fitting(modules: readonly Summary[], { text, kind, robot }: Filter): Summary[] {
  const words = text.toLowerCase().split(/\s+/).filter(Boolean);
  return modules
    .filter((module) => kind === "all" || module.kind === kind)
    .filter((module) => robot === "" || module.agents.some((place) => place.robot === robot))
    .filter((module) => words.every((word) => spoken(module).includes(word)))
    .sort((a, b) => rank(a) - rank(b) || byName(a.name, b.name));
}

function spoken({ name, help, agents }: Summary): string {
  return [name, help, ...agents.map(({ agent }) => agent)].join(" ").toLowerCase();
}

function rank({ kind }: Summary): number {
  return kind === "skill" ? 0 : 1;
}
