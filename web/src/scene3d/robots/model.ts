/** Loads a robot's model from its URDF, with few draw calls: one mesh for each link. */

import { useQuery } from "@tanstack/react-query";
import {
  BufferAttribute,
  type BufferGeometry,
  Color,
  LoadingManager,
  Mesh,
  MeshLambertMaterial,
  type MeshPhongMaterial,
  type Object3D,
} from "three";
import { STLLoader } from "three/examples/jsm/loaders/STLLoader.js";
import { mergeGeometries, toCreasedNormals } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import URDFLoader, { type URDFRobot } from "urdf-loader";
import { ApiProblem, BASE } from "../../api/client";
import { keys } from "../../api/keys";

const CREASE = 0.6; // rad: sharper edges are not smoothed
const UNPREPARED = [202, 503];
const MOST_TRIES = 60;
const MATERIAL = new MeshLambertMaterial({ vertexColors: true });

/** Returns the model of a robot, or of a device without a robot; null while loading, and without a model. */
export function useModel(id: string, name: string): URDFRobot | null {
  const { data } = useQuery({ queryKey: keys.robotModels(id, name), queryFn: () => loadModel(id), gcTime: 0 });
  return data ?? null;
}

async function loadModel(id: string): Promise<URDFRobot | null> {
  const address = `${BASE}/api/v1/robots/${encodeURIComponent(id)}/model`;
  const response = await prepared(address);
  if (response.status === 404) return null;
  if (!response.ok) throw new ApiProblem(response.status, undefined);
  const model = await parsed(await response.text(), address.replace(/[^/]*$/, ""));
  for (const link of Object.values(model.links)) condense(link);
  for (const joint of Object.values(model.joints)) joint.ignoreLimits = true; // joints show the measured position
  return model;
}

/** Polls until the model is prepared, which takes seconds the first time. */
async function prepared(address: string): Promise<Response> {
  for (let tries = 0; ; tries++) {
    const response = await fetch(address);
    if (!UNPREPARED.includes(response.status) || tries === MOST_TRIES) return response;
    const pause = Number(response.headers.get("Retry-After") ?? 1);
    await new Promise((resume) => setTimeout(resume, 1000 * Math.max(pause, 1)));
  }
}

function parsed(urdf: string, folder: string): Promise<URDFRobot> {
  return new Promise((resolve, reject) => {
    const manager = new LoadingManager();
    const loader = new URDFLoader(manager);
    loader.loadMeshCb = (path, _manager, material, done) => {
      new STLLoader(manager).load(path, (geometry) => done(new Mesh(smooth(geometry), material)), undefined, reject);
    };
    manager.itemStart(folder); // so that loading does not end before it has started
    loader.workingPath = folder;
    const model = loader.parse(urdf);
    manager.onLoad = () => resolve(model);
    manager.itemEnd(folder);
  });
}

function smooth(geometry: BufferGeometry): BufferGeometry {
  const smoothed = toCreasedNormals(geometry, CREASE);
  if (smoothed !== geometry) geometry.dispose();
  return smoothed;
}

/** Merges the visual geometries of a link into one mesh. */
function condense(link: Object3D): void {
  const visuals = link.children.filter((child) => "isURDFVisual" in child);
  const pieces = visuals.flatMap((visual) => piecesOf(visual, link));
  for (const visual of visuals) visual.removeFromParent();
  if (pieces.length === 0) return;
  const mesh = new Mesh(mergeGeometries(pieces), MATERIAL);
  for (const piece of pieces) piece.dispose();
  link.add(mesh);
}

function piecesOf(visual: Object3D, link: Object3D): BufferGeometry[] {
  const pieces: BufferGeometry[] = [];
  link.updateWorldMatrix(true, true);
  const toLink = link.matrixWorld.clone().invert();
  visual.traverse((object) => {
    if (!(object instanceof Mesh)) return;
    const geometry = plain(object.geometry as BufferGeometry).applyMatrix4(toLink.clone().multiply(object.matrixWorld));
    pieces.push(coloured(geometry, (object.material as MeshPhongMaterial).color));
  });
  return pieces;
}

/** The geometry reduced to common attributes: positions and normals. */
function plain(geometry: BufferGeometry): BufferGeometry {
  const flat = geometry.index === null ? geometry.clone() : geometry.toNonIndexed();
  geometry.dispose();
  for (const name of Object.keys(flat.attributes)) {
    if (name !== "position" && name !== "normal") flat.deleteAttribute(name);
  }
  return flat;
}

function coloured(geometry: BufferGeometry, colour: Color): BufferGeometry {
  const count = geometry.getAttribute("position").count;
  const colours = new Float32Array(count * 3);
  for (let i = 0; i < count; i++) colour.toArray(colours, 3 * i);
  return geometry.setAttribute("color", new BufferAttribute(colours, 3));
}

/** Releases a model's resources on the graphics card. */
export function disposeModel(model: Object3D): void {
  model.traverse((object) => {
    if (object instanceof Mesh) (object.geometry as BufferGeometry).dispose();
  });
}
