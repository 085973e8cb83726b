/** The cache of queries; they are fetched again after events that invalidate them, not periodically. */

import { QueryClient } from "@tanstack/react-query";
import { ApiProblem } from "./client";

const FORGOTTEN_AFTER = 5 * 60_000; // ms

export const queryClient = new QueryClient({
  defaultOptions: {
    queries: {
      staleTime: Number.POSITIVE_INFINITY,
      gcTime: FORGOTTEN_AFTER,
      refetchOnWindowFocus: false,
      retry: (count, error) => count < 2 && !(error instanceof ApiProblem && error.status < 500),
    },
  },
});
