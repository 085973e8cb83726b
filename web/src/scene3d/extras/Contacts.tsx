import { useEffect, useMemo } from "react";
import {
  type Box3,
  DataTexture,
  InstancedMesh,
  LinearFilter,
  Matrix4,
  MeshBasicMaterial,
  PlaneGeometry,
  RGBAFormat,
  Vector3,
} from "three";
import { crowd } from "../elements/crowd";
import type { Palette } from "../palette";
import { quality } from "../quality";
import { wake } from "../ticker";
import { useShownView } from "../useShownView";

const SIZE = 64; // px of the texture
const SPREAD = 1.35; // size of the shadow relative to the element
const LOW = 0.02; // m: elements higher above the floor cast none

/** Soft shadows under elements on the floor, painted once: real shadows cost too much here. */
export function Contacts({ palette }: { palette: Palette }) {
  const view = useShownView();
  const mesh = useMemo(() => shadows(palette.shade), [palette]);
  useEffect(() => {
    put(mesh);
    wake();
  }, [mesh, view]);
  useEffect(() => () => dispose(mesh), [mesh]);
  return <primitive object={mesh} />;
}

/** Only the largest: many small ones cost more than they help. */
const most = () => (quality().software ? 64 : 256);

function shadows(opacity: number): InstancedMesh {
  const material = new MeshBasicMaterial({ map: blur(), transparent: true, opacity, depthWrite: false });
  const mesh = new InstancedMesh(new PlaneGeometry(1, 1), material, most());
  mesh.frustumCulled = false;
  mesh.raycast = () => undefined;
  return mesh;
}

function put(mesh: InstancedMesh): void {
  mesh.count = 0;
  for (const { pose, bounds } of standing().slice(0, mesh.instanceMatrix.count)) {
    const size = bounds.getSize(new Vector3());
    const middle = bounds.getCenter(new Vector3()).setZ(bounds.min.z + 0.006);
    pose.multiply(new Matrix4().makeTranslation(middle)).scale(new Vector3(size.x + 0.5, size.y + 0.5, 1));
    mesh.setMatrixAt(mesh.count++, pose);
  }
  mesh.instanceMatrix.needsUpdate = true;
}

interface Standing {
  pose: Matrix4;
  bounds: Box3;
}

/** The elements on the floor, largest first. */
function standing(): Standing[] {
  const found: Standing[] = [];
  for (const { element, frame, matrix, sure } of crowd.items()) {
    const bounds = element.shape === null ? undefined : crowd.shapeOf(element.id)?.bounds; // flat marks cast none
    if (bounds === undefined || !sure || frame.on !== "map" || element.kind === "floor") continue;
    if (Math.abs((matrix.elements[14] ?? 0) + bounds.min.z) <= LOW) found.push({ pose: matrix.clone(), bounds });
  }
  return found.sort((one, other) => area(other.bounds) - area(one.bounds));
}

function area({ min, max }: Box3): number {
  return (max.x - min.x) * (max.y - min.y);
}

/** Dark in the middle, transparent at the edge. */
function blur(): DataTexture {
  const data = new Uint8Array(SIZE * SIZE * 4);
  for (let i = 0; i < SIZE * SIZE; i++) {
    const [x, y] = [(i % SIZE) / (SIZE - 1) - 0.5, Math.floor(i / SIZE) / (SIZE - 1) - 0.5];
    const rim = Math.max(0, 1 - Math.hypot(Math.abs(2 * x) ** SPREAD, Math.abs(2 * y) ** SPREAD));
    data[4 * i + 3] = 255 * rim * rim * (3 - 2 * rim);
  }
  const texture = new DataTexture(data, SIZE, SIZE, RGBAFormat);
  texture.magFilter = LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

function dispose(mesh: InstancedMesh): void {
  const material = mesh.material as MeshBasicMaterial;
  material.map?.dispose();
  material.dispose();
  mesh.geometry.dispose();
  mesh.dispose();
}
