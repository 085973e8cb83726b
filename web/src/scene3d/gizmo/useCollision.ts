import { useDebouncedValue } from "@mantine/hooks";
import { useQuery } from "@tanstack/react-query";
import { api } from "../../api/client";
import { useMay } from "../../api/session";
import type { MapPose } from "../tools";
import { useBodyIds } from "./useMovable";

const MOVING = 150; // ms
const NOTHING: readonly string[] = [];

/** Ids of the bodies in which a body would be at a pose, as the simulation says; empty without a simulation. */
export function useCollision(id: string, pose: MapPose | null): readonly string[] {
  const [asked] = useDebouncedValue(pose, MOVING);
  const may = useMay("move_body");
  const has = useBodyIds(pose !== null).has(id);
  const { data } = useQuery({
    queryKey: ["collision", id, asked],
    queryFn: async () => {
      if (asked === null) return NOTHING;
      const params = { path: { element: id }, query: { check: true } };
      const { error } = await api.PUT("/api/v1/simulation/bodies/{element}/pose", { params, body: asked });
      const { hits } = (error ?? {}) as { hits?: Record<string, number> };
      return Object.keys(hits ?? {});
    },
    enabled: may && has && asked !== null,
    gcTime: 0,
  });
  return (pose !== null && data) || NOTHING;
}
