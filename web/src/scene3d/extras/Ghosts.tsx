import { useFrame } from "@react-three/fiber";
import { useQuery } from "@tanstack/react-query";
import { useEffect, useMemo, useRef } from "react";
import { type Group, MeshLambertMaterial } from "three";
import { answer, api, type Schema } from "../../api/client";
import { keys } from "../../api/keys";
import { crowd } from "../elements/crowd";
import { useGhosts } from "../ghosts";
import { useLayers } from "../layers";
import type { Palette } from "../palette";
import { useReplay } from "../replay";
import { shapeOf } from "../shapes";
import { wake } from "../ticker";
import { useLiveView } from "../view";
import { type GhostSpot, ghostSpots } from "./ghostSpots";
import { ghostsOf } from "./goals";

const MOST = 60;

/** Ghosts at the targets of the edited goal and of running jobs. */
export function Ghosts({ palette }: { palette: Palette }) {
  const shown = useLayers((layers) => layers.shown.ghosts);
  const past = useReplay((state) => state.replay !== null);
  const spots = useSpots();
  const material = useMemo(() => {
    return new MeshLambertMaterial({ color: palette.ghost, transparent: true, opacity: 0.4, depthWrite: false });
  }, [palette]);
  useEffect(() => () => material.dispose(), [material]);
  useEffect(() => wake(), [spots, shown, past]);
  if (!shown || past) return null;
  return spots.map((spot) => <GhostMesh key={spot.ghost.key} spot={spot} material={material} />);
}

function useSpots(): GhostSpot[] {
  const requested = useGhosts((state) => state.ghosts);
  const view = useLiveView((state) => state.view);
  const { data: jobs } = useQuery({
    queryKey: keys.jobs("running", "goals"),
    queryFn: () => answer(api.GET("/api/v1/jobs", { params: { query: { state: ["Running"] } } })),
  });
  return useMemo(() => {
    if (view === null) return [];
    const ordered = (jobs?.items ?? []).flatMap((job) => ghostsOf(job as Schema<"Job">, view));
    const bounds = (key: string) => (key in view.shapes ? shapeOf(key, view.shapes[key]).bounds : null);
    return ghostSpots([...requested, ...ordered].slice(0, MOST), view, bounds);
  }, [requested, view, jobs]);
}

function GhostMesh({ spot, material }: { spot: GhostSpot; material: MeshLambertMaterial }) {
  const group = useRef<Group>(null);
  const blocks = useLiveView((state) => state.view?.shapes[spot.shape]);
  useFrame(() => {
    if (group.current === null) return;
    group.current.visible = crowd.poseOf(spot.anchor, group.current.matrix);
    group.current.matrix.multiply(spot.matrix);
  });
  return (
    <group ref={group} matrixAutoUpdate={false}>
      <mesh geometry={shapeOf(spot.shape, blocks).geometry} material={material} renderOrder={1} />
    </group>
  );
}
