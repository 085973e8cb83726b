/** Locks: who alone may edit what. One's own are kept while a form is open, and end by themselves if the page dies. */

import { useQuery } from "@tanstack/react-query";
import { useEffect, useState } from "react";
import { answer, api } from "../../api/client";
import { keys } from "../../api/keys";
import { problemText } from "../../widgets/problems";

const LASTS = 60; // s
const RENEWED = 25_000; // ms
const LOOKED_AT = 5000; // ms: there are no events for locks

export function useLocks() {
  return useQuery({
    queryKey: keys.world("locks"),
    queryFn: async () => (await answer(api.GET("/api/v1/locks"))).items,
    refetchInterval: LOOKED_AT,
  });
}

// One after the other: what is given back must not overtake what was taken.
let turn: Promise<unknown> = Promise.resolve();

function inTurn<Result>(action: () => Promise<Result>): Promise<Result> {
  const done = turn.then(action);
  turn = done.catch(() => undefined);
  return done;
}

const lock = (element: string) =>
  inTurn(() => answer(api.POST("/api/v1/locks", { body: { elements: [element], seconds: LASTS } })));
const release = (element: string) =>
  inTurn(() => api.DELETE("/api/v1/locks", { params: { query: { elements: [element] } } }));

/** Keeps others from editing an element while the component is there; returns why that cannot be, or nothing. */
export function useLock(element: string): string {
  const [refused, setRefused] = useState("");
  useEffect(() => {
    const take = () =>
      lock(element).then(
        () => setRefused(""),
        (error: unknown) => setRefused(problemText(error)),
      );
    void take();
    const timer = setInterval(() => void take(), RENEWED);
    return () => {
      clearInterval(timer);
      void release(element).catch(() => undefined); // it ends by itself
    };
  }, [element]);
  return refused;
}
