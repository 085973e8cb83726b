import { useQuery } from "@tanstack/react-query";
import { Matrix4 } from "three";
import { useSimulation } from "../../api/cell";
import { answer, answerWithTag, api, type Schema } from "../../api/client";
import { keys } from "../../api/keys";
import { useMay } from "../../api/session";
import { useWorks } from "../../live/station";
import { crowd } from "../elements/crowd";
import { poseOf } from "../pose";
import { type MapPose, type Tool, useTools } from "../tools";
import { useLiveView, type ViewElement } from "../view";

/** Why an element cannot be moved, as the key of a text; null if it can. */
export type Obstacle = "robot" | "held" | "works" | "noBody" | "noSimulator" | "mayNot" | "replayed" | null;

/** An element with the data needed to move it. */
export interface Movable {
  /** Element in whose frame its pose is stored; null for the map. */
  frame: string | null;
  /** Version on which an edit is based: as a number, and as an ETag. */
  version: number;
  tag: string;
}

/** Fetches the elements on which the believed pose of an element depends. */
export function useMovable(id: string, wanted: boolean) {
  return useQuery({
    queryKey: keys.world("movable", id),
    enabled: wanted,
    queryFn: async (): Promise<Movable> => {
      const path = { element: id };
      const { data, tag } = await answerWithTag(api.GET("/api/v1/elements/{element}", { params: { path } }));
      const pose = data.properties["sk:pose"]?.value as { frame?: string | null } | undefined;
      return { frame: pose?.frame ?? null, version: data.version, tag };
    },
  });
}

/** Whether there is a simulator, and therefore bodies. */
export function useSimulates(): boolean {
  return useSimulation().data?.simulates ?? false;
}

const BODIES_EVERY = 500; // ms: the simulator's truth has no events

/** The true poses of bodies; polled only while bodies are moved. */
export function useBodies(): readonly Schema<"SimulatedBody">[] {
  const simulates = useSimulates();
  const wanted = useTools(({ tool }) => tool === "body") && simulates;
  const { data } = useQuery({
    queryKey: keys.station("bodies"),
    queryFn: () => answer(api.GET("/api/v1/simulation/bodies")),
    enabled: wanted,
    refetchInterval: BODIES_EVERY,
    gcTime: 0,
  });
  return (wanted && data?.items) || NOBODY;
}

/** Ids of the simulated bodies; fetched once. */
export function useBodyIds(wanted: boolean): ReadonlySet<string> {
  const simulates = useSimulates();
  const { data } = useQuery({
    queryKey: keys.station("body ids"),
    queryFn: async () => {
      const { items } = await answer(api.GET("/api/v1/simulation/bodies"));
      return new Set(items.map(({ id }) => id));
    },
    enabled: wanted && simulates,
  });
  return data ?? NO_IDS;
}

const NO_IDS: ReadonlySet<string> = new Set();
const NOBODY: readonly Schema<"SimulatedBody">[] = [];

/** Why an element cannot be moved by a tool now. */
export function useObstacle(tool: Tool, element: ViewElement | undefined): Obstacle {
  const works = useWorks();
  const mayEdit = useMay("change_element");
  const mayMove = useMay("move_body");
  const simulates = useSimulates();
  const hasBody = useBodies().some((body) => body.id === element?.id);
  if (element?.kind === "robot" || element?.kind === "device") return "robot";
  if (tool === "body") return !mayMove ? "mayNot" : !simulates ? "noSimulator" : hasBody ? null : "noBody";
  if (!mayEdit) return "mayNot";
  if (element?.held_by) return "held";
  return works ? "works" : null;
}

/** The pose in the map of an element as drawn; null if it is not drawn. */
export function poseInMap(id: string): MapPose | null {
  const matrix = new Matrix4();
  return crowd.poseOf(id, matrix) ? poseOf(matrix) : null;
}

/** The pose that a tool edits: the believed or the true one. */
export function startOf(tool: Tool, id: string, bodies: readonly Schema<"SimulatedBody">[]): MapPose | null {
  const body = tool === "body" ? bodies.find((one) => one.id === id) : undefined;
  return body === undefined ? poseInMap(id) : (body as unknown as MapPose);
}

/** The selected element with its believed pose. */
export function useElement(id: string | null): ViewElement | undefined {
  return useLiveView(({ view }) => (id === null ? undefined : view?.elements.get(id)));
}
