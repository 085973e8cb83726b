/** The user and their permissions. */

import { useQuery } from "@tanstack/react-query";
import { answer, api, ApiProblem, type Schema } from "./client";
import { keys } from "./keys";
import type { operations } from "./schema";

export type Operation = keyof operations;

export function useMe() {
  return useQuery<Schema<"Me">>({ queryKey: keys.me, queryFn: () => answer(api.GET("/api/v1/session")), retry: false });
}

/** Whether the login has ended (its key is no longer valid), while the server answers. */
export function useLoginEnded(): boolean {
  const { error } = useMe();
  return error instanceof ApiProblem && error.status === 401;
}

/** Whether the role may call an operation; false until that is known. */
export function useMay(operation: Operation): boolean {
  const { data } = useMe();
  return data?.operations.includes(operation) ?? false;
}
