import { classesOf } from "../world/classes";
import type { RelationInfo } from "../world/queries";
import { neighbours } from "./neighbours";
import { shownClasses } from "./search";

const node = (name: string, children: ReturnType<typeof classesTree>[] = [], parents: string[] = []) =>
  classesTree(name, children, parents);

function classesTree(name: string, children: never[] | object[], parents: string[]) {
  return { name, label: name, comment: "", instances: 0, parents, children, children_total: children.length } as never;
}

const many = Array.from({ length: 20 }, (_, index) => node(`sk:Kind${index}`, [], ["sk:Part"]));
const classes = classesOf(node("sk:Element", [node("sk:Part", many, ["sk:Element"])]));
const relation = (name: string, computed: boolean) =>
  ({ name, computed, family: "plain", objects: [["sk:Place"]] }) as unknown as RelationInfo;
const part = { name: "sk:Part", parents: ["sk:Element"], relations_from: ["sk:in", "sk:near"] };

test("only some of many subclasses are drawn, and the others are counted", () => {
  const { nodes, left } = neighbours(part, classes, []);
  expect(nodes).toHaveLength(1 + 1 + 8);
  expect(left).toBe(12);
});

test("a class reached by a relation shows the relation; computed relations hold everywhere and are omitted", () => {
  const { nodes, edges } = neighbours(part, classes, [relation("sk:in", false), relation("sk:near", true)]);
  expect(nodes.find(({ id }) => id === "sk:Place")?.subtitle).toBe("sk:in");
  expect(edges).toContainEqual({ from: "sk:Part", to: "sk:Place" });
});

test("search results are shown with all their ancestors, so that the tree is connected", () => {
  expect(shownClasses(classes, "kind7")).toEqual(new Set(["sk:Kind7", "sk:Part", "sk:Element"]));
});
