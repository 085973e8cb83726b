/** All elements of one shape and material in a single draw call. */

import {
  type BufferGeometry,
  type Color,
  DynamicDrawUsage,
  InstancedMesh,
  type Material,
  type Matrix4,
  MeshLambertMaterial,
} from "three";
import { quality } from "../quality";
import type { Shape } from "../shapes";

/** How an element is drawn: solid, solid and part of a robot, compartment, or with an unknown pose. */
export type Appearance = "solid" | "borne" | "room" | "unsure";

/** Drawn before everything else at the same depth: the robot's model contains its deck, too, and both would flicker. */
const IN_FRONT = { polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -4 };

const MATERIALS: Record<Appearance, Material> = {
  solid: new MeshLambertMaterial({ vertexColors: true }),
  borne: new MeshLambertMaterial({ vertexColors: true, ...IN_FRONT }),
  room: new MeshLambertMaterial({ transparent: true, opacity: 0.16, depthWrite: false }),
  unsure: new MeshLambertMaterial({ vertexColors: true, transparent: true, opacity: 0.45, depthWrite: false }),
};
const ROOM_TO_GROW = 1.5;
const MANY = 36_000; // triangle vertices, which software rendering draws in some 20 ms

export class Batch {
  readonly mesh: InstancedMesh;
  readonly ids: string[] = [];

  constructor(shape: Shape, appearance: Appearance, count: number) {
    this.mesh = new InstancedMesh(geometryFor(shape, count), MATERIALS[appearance], Math.ceil(count * ROOM_TO_GROW));
    this.mesh.frustumCulled = false; // its instances are everywhere
    this.mesh.instanceMatrix.setUsage(DynamicDrawUsage);
    this.mesh.userData["ids"] = this.ids;
    this.mesh.renderOrder = MATERIALS[appearance].transparent ? 1 : 0;
    this.clear();
  }

  fits(shape: Shape, count: number): boolean {
    return this.mesh.geometry === geometryFor(shape, count) && this.mesh.instanceMatrix.count >= count;
  }

  clear(): void {
    this.ids.length = 0;
    this.mesh.count = 0;
  }

  /** Adds an instance; returns its number. */
  add(id: string): number {
    this.mesh.count = this.ids.push(id);
    return this.mesh.count - 1;
  }

  move(number: number, matrix: Matrix4): void {
    this.mesh.setMatrixAt(number, matrix);
    this.mesh.instanceMatrix.needsUpdate = true;
    this.mesh.boundingSphere = null; // computed again for the next hit test
  }

  paint(number: number, colour: Color): void {
    this.mesh.setColorAt(number, colour);
    if (this.mesh.instanceColor !== null) this.mesh.instanceColor.needsUpdate = true;
  }

  dispose(): void {
    this.mesh.removeFromParent();
    this.mesh.dispose();
  }
}

/** With software rendering, large batches are drawn as boxes: otherwise each turn of the view takes half a second. */
function geometryFor({ geometry, coarse }: Shape, count: number): BufferGeometry {
  const corners = count * (geometry.index?.count ?? geometry.getAttribute("position").count);
  return corners > MANY && quality().software ? coarse : geometry;
}
