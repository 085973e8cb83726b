import { classesOf, nameOf } from "./names";

test("a name contains label and id without repetition", () => {
  expect(nameOf("pallet_a", "pallet A")).toBe("pallet A");
  expect(nameOf("relay_box_2", "relay box")).toBe("relay_box_2");
  expect(nameOf("relay_box_17", "RelayBox")).toBe("relay_box_17");
  expect(nameOf("kit_1_a", "compartment A")).toBe("compartment A (kit_1_a)");
  expect(nameOf("kitting:standard_kit", "standard kit")).toBe("standard kit");
  expect(nameOf("thing_1", "")).toBe("thing_1");
});

test("a class is listed before its subclasses", () => {
  const leaf = { label: "", comment: "", parents: [], instances: 0, children: [], children_total: 0 };
  const tree = { ...leaf, name: "a", children: [{ ...leaf, name: "b" }] };
  expect(classesOf(tree).map(({ name }) => name)).toEqual(["a", "b"]);
});
