/** Who removed an element, and when. */

import { useQuery } from "@tanstack/react-query";
import { answer, api, isGone, type Schema } from "../../api/client";
import { keys } from "../../api/keys";
import type { Edit } from "../tree/concerned";

type Change = Schema<"Change">;

/** Returns the change that removed an element, if it is the last one of that element. */
export function removalIn([last]: readonly Change[], id: string): Change | null {
  const went = ({ edit, element, new: now }: Edit) => edit === "element" && element === id && now === null;
  return last !== undefined && (last.edits as unknown as Edit[]).some(went) ? last : null;
}

/** The change that removed an element; null if it was not removed, or unknown. */
export function useRemoval(id: string, asked = true) {
  return useQuery({
    queryKey: keys.world("removal", id),
    queryFn: () => read(id),
    enabled: asked,
  });
}

async function read(id: string): Promise<Change | null> {
  const params = { path: { element: id }, query: { limit: 1 } };
  try {
    return removalIn((await answer(api.GET("/api/v1/elements/{element}/history", { params }))).items, id);
  } catch (error) {
    if (isGone(error)) return null; // it never existed
    throw error;
  }
}
