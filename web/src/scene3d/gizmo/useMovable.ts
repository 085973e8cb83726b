import { useQuery } from "@tanstack/react-query";
import { Matrix4 } from "three";
import { answer, answerWithTag, api, type Schema } from "../../api/client";
import { keys } from "../../api/keys";
import { useMay } from "../../api/session";
import { useWorks } from "../../live/station";
import { crowd } from "../elements/crowd";
import { poseOf } from "../pose";
import { type MapPose, type Tool, useTools } from "../tools";
import { useLiveView, type ViewElement } from "../view";

/** What is wrong with moving something: key of a text; null where nothing is. */
export type Obstacle = "robot" | "held" | "works" | "noBody" | "noSimulator" | "mayNot" | "replayed" | null;

/** An element as it is read to be moved. */
export interface Movable {
  /** Element in whose frame its pose is kept; null for the map. */
  frame: string | null;
  /** Version on which an edit is based; as a number, and as it is sent. */
  version: number;
  tag: string;
}

/** Reads what the belief about an element's pose hangs on. */
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

/** Whether a simulator runs, which alone has bodies. */
export function useSimulates(): boolean {
  const { data } = useQuery({
    queryKey: keys.station("simulation"),
    queryFn: () => answer(api.GET("/api/v1/simulation")),
  });
  return data?.simulates ?? false;
}

const BODIES_EVERY = 500; // ms: there are no events for the truth

/** Where everything really is; read only while bodies are being moved. */
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

/** Where an element is drawn in the map at this moment; null for nowhere. */
export function poseInMap(id: string): MapPose | null {
  const matrix = new Matrix4();
  return crowd.poseOf(id, matrix) ? poseOf(matrix) : null;
}

/** Where a tool finds an element: as believed, or as it really is. */
export function startOf(tool: Tool, id: string, bodies: readonly Schema<"SimulatedBody">[]): MapPose | null {
  const body = tool === "body" ? bodies.find((one) => one.id === id) : undefined;
  return body === undefined ? poseInMap(id) : (body as unknown as MapPose);
}

/** The element that is selected, as it is believed to be. */
export function useElement(id: string | null): ViewElement | undefined {
  return useLiveView(({ view }) => (id === null ? undefined : view?.elements.get(id)));
}
