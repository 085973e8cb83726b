import { Line } from "@react-three/drei";
import { keepPreviousData, useQuery } from "@tanstack/react-query";
import { useEffect, useMemo } from "react";
import { BufferAttribute, BufferGeometry, Matrix4, Vector3 } from "three";
import { answer, api, type Schema } from "../../api/client";
import { keys } from "../../api/keys";
import { useStation } from "../../live/station";
import { useLayers } from "../layers";
import type { Palette } from "../palette";
import { matrixOf } from "../pose";
import { quality } from "../quality";
import { useReplay } from "../replay";
import { useDevices } from "../../api/cell";
import { wake } from "../ticker";
import { Detections } from "./Detections";
import { cloudOf, thinned } from "./points";
import { crowd, useShowings } from "../elements/crowd";

interface Camera {
  id: string;
  width: number;
  height: number;
  /** [rad] */
  vertical_fov: number;
}

const FEW = 5000; // points, with software rendering: a full cloud would double the frame time
const LASTS = 20; // s of run time, after which detections may be outdated
const FRESH = 3; // s of run time, after which detections are shown only where their elements still are
const NEAR = 0.1; // m
const REACH = 0.35; // m, length of the pyramid that shows a camera's view

/** The last observation of each camera, for a while: viewpoint, point cloud and detections. */
export function Observations({ palette }: { palette: Palette }) {
  const { data: devices } = useDevices();
  const past = useReplay((state) => state.replay !== null);
  if (past) return null; // observations belong to the present
  return devices
    ?.flatMap(cameraOf)
    .map((camera) => <CameraObservation key={camera.id} camera={camera} palette={palette} />);
}

/** A camera, from the description of a device. */
function cameraOf({ id, description }: Schema<"DeviceInfo">): Camera[] {
  const [width, height, vertical_fov] = ["width", "height", "vertical_fov"].map((name) => Number(description[name]));
  return width && height && vertical_fov ? [{ id, width, height, vertical_fov }] : [];
}

function CameraObservation({ camera, palette }: { camera: Camera; palette: Palette }) {
  const number = useStation(({ state }) => state?.observations[camera.id] ?? 0);
  const { clouds, seen } = useLayers(({ shown }) => shown);
  const { data: observation } = useQuery({
    queryKey: keys.station("observation", camera.id, number),
    queryFn: async () => (await answer(api.GET(OBSERVATION, { params: { path: { id: camera.id } } }))) as Observation,
    enabled: number > 0 && (clouds || seen),
    placeholderData: keepPreviousData,
    gcTime: 0,
  });
  useShowings(); // where elements are believed to be
  const fresh = useStation(({ state }) => (state?.time ?? 0) - (observation?.time ?? 0) <= FRESH);
  const old = useStation(({ state }) => (state?.time ?? 0) - (observation?.time ?? 0) > LASTS);
  useEffect(() => wake(), [observation, old]);
  if (observation === undefined || observation.number === 0 || number === 0 || old) return null;
  return (
    <>
      {clouds && <CloudPoints observation={observation} />}
      {clouds && observation.pose !== null && <Frustum pose={observation.pose} camera={camera} palette={palette} />}
      {seen && <Detections seen={fresh ? observation.seen : observation.seen.filter(isThere)} palette={palette} />}
    </>
  );
}

const at = new Matrix4();

/** Whether an element of its class is still believed to lie where it was seen. */
function isThere({ type, pose }: Observation["seen"][number]): boolean {
  const seen = new Vector3(...pose.position);
  return [...crowd.items()].some(
    ({ element: { id, class: class_, held_by } }) =>
      class_ === type &&
      held_by === null &&
      crowd.poseOf(id, at) &&
      seen.distanceTo(new Vector3().setFromMatrixPosition(at)) < NEAR,
  );
}

type Observation = Schema<"Observation">;
const OBSERVATION = "/api/v1/devices/{id}/observation";

function CloudPoints({ observation }: { observation: Observation }) {
  const geometry = useMemo(() => {
    const { places, colours } = thinned(cloudOf(observation), quality().software ? FEW : Number.POSITIVE_INFINITY);
    const made = new BufferGeometry().setAttribute("position", new BufferAttribute(places, 3));
    return colours === null ? made : made.setAttribute("color", new BufferAttribute(colours, 3));
  }, [observation]);
  useEffect(() => () => geometry.dispose(), [geometry]);
  const coloured = geometry.hasAttribute("color");
  return (
    <points geometry={geometry} frustumCulled={false}>
      <pointsMaterial key={String(coloured)} size={2} sizeAttenuation={false} vertexColors={coloured} />
    </points>
  );
}

function Frustum({ pose, camera, palette }: { pose: Schema<"PoseInfo">; camera: Camera; palette: Palette }) {
  const points = useMemo(() => pyramid(camera, matrixOf(pose)), [camera, pose]);
  return <Line segments points={points} color={palette.seen} lineWidth={1.5} />;
}

/** Edges of a camera's field of view, z forward. */
function pyramid({ width, height, vertical_fov }: Camera, pose: Matrix4): Vector3[] {
  const y = REACH * Math.tan(vertical_fov / 2);
  const x = (y * width) / height;
  const rim = [
    [-x, -y],
    [x, -y],
    [x, y],
    [-x, y],
  ].map(([a = 0, b = 0]) => new Vector3(a, b, REACH).applyMatrix4(pose));
  const eye = new Vector3().applyMatrix4(pose);
  return rim.flatMap((corner, i) => [eye, corner, corner, rim[(i + 1) % rim.length] ?? corner]);
}
