/** Target places of objects according to the conditions, shown as ghosts in the 3D view. */

import type { Ghost } from "../scene3d/ghosts";
import { type GoalData, isWord } from "./goals";

/** Conditions whose first argument is to be in the second. */
const PLACING = new Set(["ObjectAtLocation", "InKit"]);

/** The ghosts of conditions that do not hold yet. */
export function ghostsOf(conditions: readonly { data: GoalData; holds: boolean }[]): Ghost[] {
  return conditions.flatMap(({ data, holds }, index) => {
    if (holds || !isWord(data) || !PLACING.has(data.condition)) return [];
    const [like, place] = data.arguments;
    return like && place ? [{ key: `goal-${index}`, like, place }] : [];
  });
}
