import { useQuery } from "@tanstack/react-query";
import { useEffect } from "react";
import { BASE } from "../api/client";
import { queryClient } from "../api/queries";
import { connect, disconnect, givenUp, useConnection } from "../live/connection";
import { keepFresh } from "../live/freshness";

const LOOK_AGAIN = 1000; // ms

/** Follows the server while somebody is let in and sees the page; a lost connection heals itself. */
export function useServer(letIn: boolean): void {
  useEffect(() => (letIn ? keepFresh() : undefined), [letIn]);
  useEffect(() => {
    if (!letIn) return;
    const follow = () => (document.hidden ? disconnect() : connect());
    follow();
    document.addEventListener("visibilitychange", follow);
    return () => {
      document.removeEventListener("visibilitychange", follow);
      disconnect();
    };
  }, [letIn]);
  useReconnection(letIn);
}

/** Browsers open a broken stream again by themselves, unless the server refused it: then we ask whether it is back. */
function useReconnection(letIn: boolean): void {
  const lost = useConnection((connection) => connection.status === "lost");
  const { dataUpdatedAt } = useQuery({
    queryKey: ["health"],
    queryFn: async () => (await fetch(`${BASE}/healthz`)).ok,
    enabled: lost,
    refetchInterval: LOOK_AGAIN,
    staleTime: 0,
    retry: false,
  });
  useEffect(() => {
    if (!lost || dataUpdatedAt === 0 || document.hidden || !givenUp()) return;
    void queryClient.invalidateQueries({ queryKey: ["me"] });
    if (letIn) connect();
  }, [lost, dataUpdatedAt, letIn]);
}
