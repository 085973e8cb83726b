import { Line } from "@react-three/drei";
import { keepPreviousData, useQuery } from "@tanstack/react-query";
import { useEffect, useMemo } from "react";
import { Quaternion, Vector3 } from "three";
import { answer, api, type Schema } from "../../api/client";
import { keys } from "../../api/keys";
import { useStation } from "../../live/station";
import { useLayers } from "../layers";
import type { Palette } from "../palette";
import { useReplay } from "../replay";
import { wake } from "../ticker";

const FLOOR = 0.015; // m: above the grid

/** Planned motions of devices, while they move. */
export function Motions({ palette }: { palette: Palette }) {
  const devices = useStation(({ state }) => Object.keys(state?.motions ?? {}).join("\n"));
  const shown = useLayers((layers) => layers.shown.paths);
  const past = useReplay((state) => state.replay !== null);
  const works = useStation(({ state }) => (state?.modules.length ?? 0) > 0);
  if (!shown || past || !works || devices === "") return null;
  return devices.split("\n").map((id) => <DeviceMotion key={id} device={id} palette={palette} />);
}

function DeviceMotion({ device, palette }: { device: string; palette: Palette }) {
  const number = useStation(({ state }) => state?.motions[device] ?? 0);
  const { data: motion } = useQuery({
    queryKey: keys.station("motion", device, number),
    queryFn: async () =>
      (await answer(
        api.GET("/api/v1/devices/{id}/motion", { params: { path: { id: device } } }),
      )) as Schema<"DeviceMotion">,
    enabled: number > 0,
    placeholderData: keepPreviousData,
    gcTime: 0,
  });
  useEffect(() => {
    wake();
    return () => wake();
  }, [motion]);
  if (motion === undefined || motion.poses.length < 2) return null;
  if (motion.poses.every(({ position }) => Math.abs(position[2]) < FLOOR))
    return <FloorPath poses={motion.poses} palette={palette} />;
  const points = motion.poses.map(({ position }) => position);
  return <Line points={points} color={palette.path} lineWidth={2} dashed dashSize={0.03} gapSize={0.02} />;
}

/** A path on the floor, with an arrow for the heading at its end. */
function FloorPath({ poses, palette }: { poses: Schema<"PoseInfo">[]; palette: Palette }) {
  const points = useMemo(() => poses.map(({ position: [x, y] }) => new Vector3(x, y, FLOOR)), [poses]);
  const end = poses.at(-1);
  if (end === undefined) return null;
  return (
    <>
      <Line points={points} color={palette.path} lineWidth={4} transparent opacity={0.75} />
      <mesh position={points.at(-1)} quaternion={new Quaternion(...end.orientation)}>
        <circleGeometry args={[0.16, 3]} />
        <meshBasicMaterial color={palette.path} />
      </mesh>
    </>
  );
}
