import { type Classes, classesOf } from "../classes";
import type { RelationInfo } from "../queries";
import { justBefore, placementsFor, relationFor } from "./placements";

const leaf = (name: string, parents: string[]) => ({ name, parents, label: name, comment: "", instances: 0 });
const classes: Classes = classesOf({
  ...leaf("sk:Element", []),
  children_total: 2,
  children: [
    { ...leaf("sk:Part", ["sk:Element"]), children: [], children_total: 0 },
    {
      ...leaf("sk:Location", ["sk:Element"]),
      children: [{ ...leaf("sk:Box", ["sk:Location", "sk:Part"]), children: [], children_total: 0 }],
      children_total: 1,
    },
  ],
});

function relation(name: string, place_end: string | null, subjects: string[][], objects: string[][]): RelationInfo {
  return { name, place_end, subjects, objects, label: name, comment: "", family: "placement", parents: [] } as never;
}

const isIn = relation("sk:in", "object", [["sk:Part"]], [["sk:Location"]]);
const holds = relation("sk:holds", "subject", [["sk:Box"]], [["sk:Part"]]);
const near = relation("sk:near", null, [["sk:Part"]], [["sk:Location"]]);

test("a part can be placed by placement relations that accept its class, whichever end is the place", () => {
  const found = placementsFor(classes, [isIn, holds, near], "sk:Part");
  expect(found.map(({ name }) => name)).toEqual(["sk:in", "sk:holds"]);
});

test("the most common relation comes first, and sk:heldBy last", () => {
  const relations = ["sk:heldBy", "sk:beside", "sk:at", "sk:on", "sk:in"].map((name) =>
    relation(name, "object", [["sk:Part"]], [["sk:Location"]]),
  );
  const found = placementsFor(classes, relations, "sk:Part").map(({ name }) => name);
  expect(found).toEqual(["sk:in", "sk:on", "sk:at", "sk:beside", "sk:heldBy"]);
});

test("all parents of a class count, not only the primary one", () => {
  expect(placementsFor(classes, [isIn], "sk:Box", "sk:Box")).toEqual([isIn]);
});

test("a place of the wrong class accepts nothing", () => {
  expect(placementsFor(classes, [isIn, holds], "sk:Part", "sk:Part")).toEqual([]);
});

test("the cursor before an id is smaller than it, and larger than the preceding id", () => {
  const cursor = justBefore("kit_1_b");
  expect(cursor < "kit_1_b").toBe(true);
  expect(cursor > "kit_1_a_long_name").toBe(true);
});

test("what skills accept is taken for a move, also of a part that was lost", () => {
  const fit = (relation: string, accepted = false, fits = true) => ({
    relation,
    label: "",
    accepted,
    fits,
    whyNot: "",
  });
  expect(relationFor([fit("sk:in", true), fit("sk:on")], "sk:on")).toBe("sk:in");
  expect(relationFor([fit("sk:in"), fit("sk:on")], "sk:on")).toBe("sk:on");
  expect(relationFor([fit("sk:in", true, false), fit("sk:on")], "sk:at")).toBeUndefined();
});
