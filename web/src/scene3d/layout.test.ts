import { describe, expect, it } from "vitest";
import { Box3, Vector3 } from "three";
import { layout } from "./layout";
import { boundsOf } from "./shapes";
import { at, box, element, world } from "./testing";
import { viewFrom, type ViewElement } from "./view";

const SHAPES = { table: [box(0.4, 0.8, 0.5)], part: [box(0.1, 0.05, 0.03)] };

function laidOut(...elements: ViewElement[]) {
  const view = viewFrom(world(elements, { shapes: SHAPES }));
  return layout(view, ({ shape }) => (shape === null ? null : boundsOf(view.shapes[shape] ?? [])));
}

function where(items: ReturnType<typeof laidOut>, id: string): Vector3 {
  return new Vector3().setFromMatrixPosition(items.get(id)!.matrix); // eslint-disable-line @typescript-eslint/no-non-null-assertion
}

const TABLE = element("table", { kind: "place", shape: "table", pose: at(2, 0, 0) });

describe("a layout", () => {
  it("places elements in the map or on the base that carries them", () => {
    const items = laidOut(TABLE, element("deck", { pose: at(0, 0, 0.3), carrier: "base_1" }));
    expect(items.get("table")?.frame.on).toBe("map");
    expect(items.get("deck")?.frame).toEqual({ on: "carrier", id: "base_1" });
  });

  it("draws a device that carries bodies at its frame, even while nothing else changes", () => {
    const view = viewFrom(world([element("turntable", { kind: "device", shape: "table", pose: at(1, 0, 0) })]));
    const items = layout(
      view,
      () => null,
      (id) => id === "turntable",
    );
    expect(items.get("turntable")?.frame).toEqual({ on: "carrier", id: "turntable" });
  });

  it("places held elements in the hand", () => {
    const items = laidOut(element("a", { place: "gripper", held_by: "gripper", in_hand: at(0, 0, -0.02) }));
    expect(items.get("a")).toMatchObject({ frame: { on: "tool", id: "gripper" }, sure: true });
  });

  it("places a robot on its base", () => {
    const base = element("base_1", { kind: "device", owner: "robot", pose: at(1, 0, 0) });
    const items = laidOut(element("robot", { kind: "robot", pose: at(1, 0, 0) }), base);
    expect(items.get("robot")?.frame).toEqual({ on: "carrier", id: "base_1" });
  });

  it("places elements without a known pose above their place, apart from each other", () => {
    const ids = ["a", "b", "c", "d", "e", "f", "g"];
    const items = laidOut(...ids.map((id) => element(id, { place: "table", shape: "part" })), TABLE);
    const boxes = ids.map((id) => boundsOf(SHAPES.part).translate(where(items, id)));
    for (const one of boxes) expect(one.min.z).toBeGreaterThan(0.5);
    for (const [i, one] of boxes.entries()) {
      for (const other of boxes.slice(i + 1)) expect(one.intersectsBox(other)).toBe(false);
    }
    expect(items.get("a")?.sure).toBe(false);
    const all = boxes.reduce((sum, one) => sum.union(one), new Box3());
    expect(all.getCenter(new Vector3()).x).toBeCloseTo(2);
  });

  it("does so above such elements, too, and ends if places form a cycle", () => {
    const items = laidOut(
      element("inner", { place: "tray", shape: "part" }),
      element("tray", { place: "table", shape: "table" }),
      element("x", { place: "y" }),
      element("y", { place: "x" }),
      TABLE,
    );
    expect(where(items, "inner").z).toBeGreaterThan(where(items, "tray").z);
    expect(items.has("x")).toBe(false);
  });
});
