import i18n from "../i18n";
import { byName, classesOf, nameOf, withoutCommon } from "./names";

test("a name contains label and id without repetition", () => {
  expect(nameOf("pallet_a", "pallet A")).toBe("pallet A");
  expect(nameOf("relay_box_2", "relay box")).toBe("relay_box_2");
  expect(nameOf("relay_box_17", "RelayBox")).toBe("relay_box_17");
  expect(nameOf("kit_1_a", "compartment A")).toBe("compartment A (kit_1_a)");
  expect(nameOf("kitting:standard_kit", "standard kit")).toBe("standard kit");
  expect(nameOf("thing_1", "")).toBe("thing_1");
});

test("names are shortened by what they have in common, as long as something remains", () => {
  expect(withoutCommon(["panda_joint1", "panda_joint2"])).toEqual(["joint1", "joint2"]);
  expect(withoutCommon(["panda_joint1", "elbow"])).toEqual(["panda_joint1", "elbow"]);
  expect(withoutCommon(["panda_joint1"])).toEqual(["panda_joint1"]);
});

test("names are ordered as people count", () => {
  expect(["p_10", "p_2", "P_1"].sort(byName)).toEqual(["P_1", "p_2", "p_10"]);
});

test("a label written from right to left turns nothing but itself", () => {
  expect(nameOf("box_1", "\u202exob")).toBe("\u2068\u202exob\u2069 (box_1)");
  expect(i18n.t("pick.any", { class: "\u202exob" })).toBe("any \u2068\u202exob\u2069");
});

test("a class is listed before its subclasses", () => {
  const leaf = { label: "", comment: "", parents: [], instances: 0, children: [], children_total: 0 };
  const tree = { ...leaf, name: "a", children: [{ ...leaf, name: "b" }] };
  expect(classesOf(tree).map(({ name }) => name)).toEqual(["a", "b"]);
});
