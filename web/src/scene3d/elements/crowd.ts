/** The elements of a view as drawn: few draw calls; only carried and held elements are updated each frame. */

import { Box3, type Color, Group, Matrix4 } from "three";
import { create } from "zustand";
import { frameInMap } from "../frames";
import { type Item, layout } from "../layout";
import { type Shape, shapeIn } from "../shapes";
import type { View, ViewElement } from "../view";
import { Batch, type Appearance } from "./Batch";

interface Drawn {
  item: Item;
  batch: Batch | null;
  number: number;
}

const frame = new Matrix4();
const pose = new Matrix4();

class Crowd {
  readonly group = new Group();
  private readonly batches = new Map<string, Batch>();
  private drawn = new Map<string, Drawn>();
  private riders: Drawn[] = [];
  private shapes: View["shapes"] = {};

  /** Shows a view. Hidden elements have a pose but are not drawn; carriers are devices, drawn at their frames. */
  show(view: View, hidden: (element: ViewElement) => boolean, carriers: ReadonlySet<string>): void {
    this.shapes = view.shapes;
    const bounds = (element: ViewElement) => this.shape(element)?.bounds ?? null;
    const items = layout(view, bounds, (id) => carriers.has(id));
    const visible = [...items.values()].filter((item) => !hidden(item.element));
    this.makeRoom(visible);
    this.drawn = new Map([...items].map(([id, item]) => [id, { item, batch: null, number: 0 }]));
    for (const item of visible) this.enlist(item);
    this.riders = [...this.drawn.values()].filter(({ item, batch }) => batch !== null && item.frame.on !== "map");
    for (const one of this.drawn.values()) this.place(one);
    useShowings.setState((count) => count + 1, true);
  }

  /** Updates the elements that move with a robot. */
  follow(): void {
    for (const one of this.riders) this.place(one);
  }

  paint(colour: (element: ViewElement, sure: boolean) => Color): void {
    for (const { item, batch, number } of this.drawn.values()) batch?.paint(number, colour(item.element, item.sure));
  }

  ids(): string[] {
    return [...this.drawn.keys()];
  }

  item(id: string): Item | undefined {
    return this.drawn.get(id)?.item;
  }

  items(): IterableIterator<Item> {
    return (function* (all) {
      for (const { item } of all) yield item;
    })(this.drawn.values());
  }

  /** Writes the pose of an element as drawn; false if it is not drawn. */
  poseOf(id: string, into: Matrix4): boolean {
    const one = this.drawn.get(id);
    if (one === undefined || !frameInMap(one.item.frame, into)) return false;
    into.multiply(one.item.matrix);
    return true;
  }

  shapeOf(id: string): Shape | null {
    const one = this.drawn.get(id);
    return one === undefined ? null : this.shape(one.item.element);
  }

  /** The bounding box in the map of an element as drawn; null without a shape. */
  boundsOf(id: string): Box3 | null {
    const bounds = this.shapeOf(id)?.bounds;
    return bounds !== undefined && this.poseOf(id, pose) ? new Box3().copy(bounds).applyMatrix4(pose) : null;
  }

  dispose(): void {
    for (const batch of this.batches.values()) batch.dispose();
    this.batches.clear();
    this.drawn.clear();
    this.riders = [];
  }

  private shape(element: ViewElement): Shape | null {
    return shapeIn(this.shapes, element);
  }

  private makeRoom(visible: readonly Item[]): void {
    const needed = new Map<string, { shape: Shape; appearance: Appearance; count: number }>();
    for (const item of visible) {
      const need = needed.get(keyOf(item));
      const shape = this.shape(item.element);
      if (need !== undefined) need.count += 1;
      else if (shape !== null) needed.set(keyOf(item), { shape, appearance: appearanceOf(item), count: 1 });
    }
    for (const [key, batch] of this.batches) {
      const need = needed.get(key);
      if (need !== undefined && batch.fits(need.shape, need.count)) batch.clear();
      else this.drop(key, batch);
    }
    for (const [key, { shape, appearance, count }] of needed) {
      if (!this.batches.has(key)) this.found(key, new Batch(shape, appearance, count));
    }
  }

  private found(key: string, batch: Batch): void {
    this.batches.set(key, batch);
    this.group.add(batch.mesh);
  }

  private drop(key: string, batch: Batch): void {
    batch.dispose();
    this.batches.delete(key);
  }

  private enlist(item: Item): void {
    const batch = this.batches.get(keyOf(item)) ?? null;
    const { id } = item.element;
    this.drawn.set(id, { item, batch, number: batch?.add(id) ?? 0 });
  }

  private place({ item, batch, number }: Drawn): void {
    if (batch === null || !frameInMap(item.frame, frame)) return;
    batch.move(number, pose.multiplyMatrices(frame, item.matrix));
  }
}

function appearanceOf({ element, sure, frame }: Item): Appearance {
  if (!sure) return "unsure";
  if (element.hollow) return "room";
  return frame.on === "carrier" ? "borne" : "solid";
}

function keyOf(item: Item): string {
  return `${appearanceOf(item)} ${item.element.shape ?? ""}`;
}

/** Counts the views shown: cached positions are invalid after each. */
export const useShowings = create<number>(() => 0);

/** The one instance, for the one view. */
export const crowd = new Crowd();
