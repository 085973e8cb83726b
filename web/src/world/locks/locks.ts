/** Locks on edited elements. Own locks are renewed while a form is open, and expire if the page dies. */

import { useQuery } from "@tanstack/react-query";
import { useEffect, useState } from "react";
import { answer, api } from "../../api/client";
import { keys } from "../../api/keys";
import { problemText } from "../../widgets/problems";

const LASTS = 60; // s
const RENEWED = 25_000; // ms
const LOOKED_AT = 5000; // ms: locks have no events

export function useLocks() {
  return useQuery({
    queryKey: keys.world("locks"),
    queryFn: async () => (await answer(api.GET("/api/v1/locks"))).items,
    refetchInterval: LOOKED_AT,
  });
}

// One request at a time: a release must not overtake its acquisition.
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

/** Locks an element while the component is mounted; returns why it cannot, or undefined. */
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
      void release(element).catch(() => undefined); // it expires
    };
  }, [element]);
  return refused;
}
