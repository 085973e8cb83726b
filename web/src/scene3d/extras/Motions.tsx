import { Line } from "@react-three/drei";
import { keepPreviousData, useQuery } from "@tanstack/react-query";
import { useEffect, useMemo } from "react";
import { Vector3 } from "three";
import { answer, api, type Schema } from "../../api/client";
import { keys } from "../../api/keys";
import { useStation } from "../../live/station";
import { useLayers } from "../layers";
import type { Palette } from "../palette";
import { useReplay } from "../replay";
import { useRobots } from "../../api/cell";
import { wake } from "../ticker";

type Motion = Schema<"RobotMotion">;

const FLOOR = 0.015; // m: above the grid

/** Planned motions of robots, while they move. */
export function Motions({ palette }: { palette: Palette }) {
  const { data: robots } = useRobots();
  const shown = useLayers((layers) => layers.shown.paths);
  const past = useReplay((state) => state.replay !== null);
  const works = useStation(({ state }) => (state?.modules.length ?? 0) > 0);
  if (!shown || past || !works) return null;
  return robots?.map(({ id }) => <RobotMotion key={id} robot={id} palette={palette} />);
}

function RobotMotion({ robot, palette }: { robot: string; palette: Palette }) {
  const number = useStation(({ state }) => state?.motions[robot] ?? 0);
  const { data: motion } = useQuery({
    queryKey: keys.station("motion", robot, number),
    queryFn: async () =>
      (await answer(api.GET("/api/v1/robots/{id}/motion", { params: { path: { id: robot } } }))) as Motion,
    enabled: number > 0,
    placeholderData: keepPreviousData,
    gcTime: 0,
  });
  useEffect(() => {
    wake();
    return () => wake();
  }, [motion]);
  if (motion === undefined) return null;
  return (
    <>
      <BaseWay way={motion.base} palette={palette} />
      {motion.arms.map(
        ({ arm, points }) =>
          points.length > 1 && (
            <Line key={arm} points={points} color={palette.path} lineWidth={2} dashed dashSize={0.03} gapSize={0.02} />
          ),
      )}
    </>
  );
}

function BaseWay({ way, palette }: { way: Motion["base"]; palette: Palette }) {
  const points = useMemo(() => way.map(({ x, y }) => new Vector3(x, y, FLOOR)), [way]);
  const end = way.at(-1);
  if (end === undefined || points.length < 2) return null;
  return (
    <>
      <Line points={points} color={palette.path} lineWidth={4} transparent opacity={0.75} />
      <mesh position={[end.x, end.y, FLOOR]} rotation={[0, 0, end.heading]}>
        <circleGeometry args={[0.16, 3]} />
        <meshBasicMaterial color={palette.path} />
      </mesh>
    </>
  );
}
