import { describe, expect, it } from "vitest";
import { boundsOf } from "../shapes";
import { at, box, element, world } from "../testing";
import { viewFrom } from "../view";
import { ghostSpots } from "./ghostSpots";
import { ghostsOf } from "./goals";

const room = (id: string) =>
  element(id, { kind: "place", owner: "kit", shape: "room", hollow: true, pose: at(0, 0, 0) });
const VIEW = viewFrom(
  world(
    [
      element("kit", { kind: "place", shape: "kit", pose: at(0, 0, 0) }),
      room("kit_a"),
      room("kit_b"),
      element("starter_1", { class: "test:Starter", shape: "test:Starter", place: "kit_a" }),
      element("starter_2", { class: "test:Starter", shape: "test:Starter", place: "pallet" }),
    ],
    { shapes: { kit: [box(0.3, 0.3, 0.01)], room: [box(0.1, 0.1, 0.03)], "test:Starter": [box(0.1, 0.03, 0.05)] } },
  ),
);
const bounds = (key: string) => (key in VIEW.shapes ? boundsOf(VIEW.shapes[key] ?? []) : null);
const anchors = (...likes: string[]) =>
  ghostSpots(
    likes.map((like, i) => ({ key: String(i), like, place: "kit" })),
    VIEW,
    bounds,
  ).map(({ anchor }) => anchor);

describe("ghosts", () => {
  it("go into free compartments, one each, and onto the kit if there are none left", () => {
    expect(anchors("Starter", "test:Starter")).toEqual(["kit_b", "kit"]);
  });

  it("are not shown for elements already at their place, nor for elements without a shape", () => {
    expect(anchors("starter_1", "Screw")).toEqual([]);
  });
});

describe("goals of a job", () => {
  const job = { id: "kit-1", conditions: [], order: { goal: ["InKit(Starter, kit)"] } };
  const ghostsFor = (rest: object) => ghostsOf({ ...job, ...rest } as unknown as Parameters<typeof ghostsOf>[0], VIEW);

  it("are derived from target places", () => {
    expect(ghostsFor({})).toMatchObject([{ like: "Starter", place: "kit" }]);
  });

  it("are those not reached yet", () => {
    const conditions = [
      { condition: "InKit(Starter, kit)", reached: true, reason: "" },
      { condition: "InKit(starter_2, kit)", reached: false, reason: "" },
    ];
    expect(ghostsFor({ conditions })).toMatchObject([{ like: "starter_2" }]);
  });

  it("without a place make no ghost", () => {
    expect(ghostsFor({ order: { goal: ["Charged(robot_1)", "Near(kit, nowhere)"] } })).toEqual([]);
  });
});
