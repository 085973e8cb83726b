import { Line } from "@react-three/drei";
import { useEffect, useMemo } from "react";
import { Box3, BoxGeometry, EdgesGeometry, Matrix4, Vector3 } from "three";
import type { Schema } from "../../api/client";
import { useFloating } from "../overlay/floating";
import type { Palette } from "../palette";
import { matrixOf } from "../pose";
import { useLiveView } from "../view";
import { boundsOf } from "../shapes";

type Seen = Schema<"Seen">;

/** Boxes around detections of the last look, with their classes. */
export function Detections({ seen, palette }: { seen: readonly Seen[]; palette: Palette }) {
  const shapes = useLiveView((state) => state.view?.shapes);
  const boxes = useMemo(() => seen.map((one) => boxOf(one, shapes?.[one.type ?? ""])), [seen, shapes]);
  const points = useMemo(() => boxes.flatMap((box, i) => edges(box, seen[i]?.pose)), [boxes, seen]);
  useEffect(() => {
    const { show } = useFloating.getState();
    show(seen.map((one, i) => ({ key: String(i), type: one.type, point: above(boxes[i], one.pose) })));
    return () => show([]);
  }, [seen, boxes]);
  return points.length > 0 && <Line segments points={points} color={palette.seen} lineWidth={2} />;
}

/** The box of a known shape, in its own frame; otherwise one of the detected size. */
function boxOf({ size }: Seen, blocks: Parameters<typeof boundsOf>[0] | undefined): Box3 {
  if (blocks !== undefined) return boundsOf(blocks);
  return new Box3().setFromCenterAndSize(new Vector3(), new Vector3(...size));
}

function edges(box: Box3, pose: Seen["pose"] | undefined): Vector3[] {
  const size = box.getSize(new Vector3());
  const geometry = new BoxGeometry(size.x, size.y, size.z);
  const found = new EdgesGeometry(geometry);
  const places = found.getAttribute("position");
  const matrix = pose === undefined ? new Matrix4() : matrixOf(pose);
  const middle = box.getCenter(new Vector3());
  const points = Array.from({ length: places.count }, (_, i) =>
    new Vector3().fromBufferAttribute(places, i).add(middle).applyMatrix4(matrix),
  );
  geometry.dispose();
  found.dispose();
  return points;
}

function above(box: Box3 | undefined, pose: Seen["pose"]): Vector3 {
  const top = box === undefined ? new Vector3() : box.getCenter(new Vector3()).setZ(box.max.z);
  return top.applyMatrix4(matrixOf(pose));
}
