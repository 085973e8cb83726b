import { useFrame } from "@react-three/fiber";
import { useEffect, useMemo } from "react";
import { BufferAttribute, BufferGeometry, CanvasTexture, Points, PointsMaterial, Vector3 } from "three";
import { crowd } from "../elements/crowd";
import type { Palette } from "../palette";
import { pointOf } from "../pointing";
import { wake } from "../ticker";
import { useShownView } from "../useShownView";

const SIZE = 18; // px
const ABOVE = 0.05; // m

/** A question mark above each element whose exact pose is unknown. */
export function Doubts({ palette }: { palette: Palette }) {
  const view = useShownView();
  const points = useMemo(() => marks(palette), [palette]);
  useEffect(() => {
    number(points);
    wake();
  }, [points, view]);
  useEffect(() => () => dispose(points), [points]);
  useFrame(() => put(points));
  return <primitive object={points} />;
}

function marks(palette: Palette): Points<BufferGeometry, PointsMaterial> {
  const map = new CanvasTexture(sign(`#${palette.unsure.getHexString()}`));
  const material = new PointsMaterial({
    map,
    size: SIZE,
    sizeAttenuation: false,
    transparent: true,
    depthWrite: false,
  });
  const points = new Points(new BufferGeometry(), material);
  points.frustumCulled = false;
  points.raycast = () => undefined;
  points.renderOrder = 2;
  return points;
}

function sign(colour: string): HTMLCanvasElement {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 2 * SIZE;
  const pen = canvas.getContext("2d");
  if (pen === null) return canvas;
  pen.fillStyle = colour;
  pen.arc(SIZE, SIZE, SIZE - 2, 0, 2 * Math.PI);
  pen.fill();
  pen.fillStyle = "#1b1b1b";
  pen.font = `bold ${1.4 * SIZE}px sans-serif`;
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.fillText("?", SIZE, SIZE + 1);
  return canvas;
}

type Marks = Points<BufferGeometry, PointsMaterial>;

/** Allocates enough marks. */
function number({ geometry, userData }: Marks): void {
  userData["ids"] = [...crowd.items()].filter((item) => !item.sure).map((item) => item.element.id);
  userData["moving"] = [...crowd.items()].some((item) => !item.sure && item.frame.on !== "map");
  userData["stale"] = true;
  geometry.dispose();
  geometry.setAttribute("position", new BufferAttribute(new Float32Array(3 * userData["ids"].length), 3));
}

const point = new Vector3();

function put({ geometry, userData }: Marks): void {
  if (userData["stale"] !== true && userData["moving"] !== true) return;
  userData["stale"] = false;
  const places = geometry.getAttribute("position");
  (userData["ids"] as string[] | undefined)?.forEach((id, i) => {
    if (pointOf(id, "top", point)) places.setXYZ(i, point.x, point.y, point.z + ABOVE);
  });
  places.needsUpdate = true;
}

function dispose({ geometry, material }: Marks): void {
  geometry.dispose();
  material.map?.dispose();
  material.dispose();
}
