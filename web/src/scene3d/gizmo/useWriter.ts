import { useState } from "react";
import type { Tool } from "../tools";
import { type Movable, useMovable } from "./useMovable";
import { useMoveBody, useWriteBelief } from "./useWrite";

export type Mover = Exclude<Tool, "select">;

/** Writes a new pose: the believed one, or that of the simulated body. */
export function useWriter(tool: Mover, id: string, drafted: boolean) {
  const { data: now, refetch } = useMovable(id, tool === "belief");
  const [based, setBased] = useState<Movable | undefined>();
  if (!drafted && now !== based) setBased(now); // an edit is based on the version at its start
  const belief = useWriteBelief(id);
  const body = useMoveBody(id);
  const current = tool === "body" ? body : belief;
  return {
    busy: current.isPending,
    problem: current.error,
    refresh: () => {
      belief.reset();
      void refetch().then(({ data }) => setBased(data));
    },
    write: (pose: Parameters<typeof body.mutate>[0], done: () => void) => {
      if (tool === "body") body.mutate(pose, { onSuccess: done });
      else if (based !== undefined) belief.mutate({ pose, movable: based }, { onSuccess: done });
    },
  };
}
