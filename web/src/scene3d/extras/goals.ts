/** The goals of a job as ghosts, if they name a target place. */

import type { Schema } from "../../api/client";
import type { Ghost } from "../ghosts";
import type { View } from "../view";

const CONDITION = /^\s*([\w:.-]+)\s*\(\s*([^,()]+?)\s*,\s*([^,()]+?)\s*\)\s*$/;

/** The target places of goals not reached yet: `InKit(Starter, kit_1)`. */
export function ghostsOf(job: Schema<"Job">, view: View): Ghost[] {
  const texts =
    job.conditions.length > 0
      ? job.conditions.filter(({ reached }) => !reached).map(({ condition }) => condition)
      : job.order.goal.flatMap((goal) => goal.split(/\)\s*(?:&|,|\band\b)\s*/).map(closed));
  return texts.flatMap((text, i) => {
    const [, , like = "", place = ""] = CONDITION.exec(text) ?? [];
    const fits = view.elements.get(place)?.kind === "place" && like !== "";
    return fits ? [{ key: `${job.id} ${i}`, like, place }] : [];
  });
}

function closed(text: string): string {
  return text.includes("(") && !text.trimEnd().endsWith(")") ? `${text})` : text;
}
