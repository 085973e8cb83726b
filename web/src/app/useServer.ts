import { useEffect } from "react";
import { ApiProblem } from "../api/client";
import { keys } from "../api/keys";
import { queryClient } from "../api/queries";
import { connect, disconnect } from "../live/connection";
import { keepFresh } from "../live/freshness";
import { watch } from "../live/watch";

/** Follows the server while the page is visible and its user logged in; reconnects after a loss. */
export function useServer(letIn: boolean): void {
  useEffect(() => (letIn ? keepFresh() : undefined), [letIn]);
  useEffect(() => (letIn ? whileSeen(followed) : undefined), [letIn]);
  useEffect(() => askAgainWhenRefused(), []);
}

function followed(): () => void {
  connect();
  const endWatch = watch(askWhoIAm);
  return () => {
    endWatch();
    disconnect();
  };
}

function askWhoIAm(): void {
  void queryClient.invalidateQueries({ queryKey: keys.me });
}

/** Runs an effect while the page is visible; returns the function that ends it. */
function whileSeen(begin: () => () => void): () => void {
  let end: (() => void) | undefined;
  const look = () => {
    if (document.hidden === (end === undefined)) return;
    if (document.hidden) {
      end?.();
      end = undefined;
    } else {
      end = begin();
    }
  };
  look();
  document.addEventListener("visibilitychange", look);
  return () => {
    document.removeEventListener("visibilitychange", look);
    end?.();
  };
}

/** After any refusal for a revoked key, fetches the session, so that the login form appears. */
function askAgainWhenRefused(): () => void {
  const look = (error: unknown) => {
    const known = queryClient.getQueryState(keys.me)?.error;
    if (error instanceof ApiProblem && error.status === 401 && !(known instanceof ApiProblem)) askWhoIAm();
  };
  const ends = [
    queryClient.getQueryCache().subscribe(({ type, query }) => {
      if (type === "updated" && query.queryKey[0] !== keys.me[0]) look(query.state.error);
    }),
    queryClient.getMutationCache().subscribe(({ type, mutation }) => {
      if (type === "updated") look(mutation?.state.error);
    }),
  ];
  return () => {
    for (const end of ends) end();
  };
}
