import { causeOf, namedIn } from "./causes";

test("names in a sentence are found, classes without prefix, but not inside other words", () => {
  const isElement = (word: string) => word === "kit_1_a";
  expect(namedIn("kit_1_a takes one Starter, not kit_1_ab.", ["kitting:Starter"], isElement)).toEqual([
    { name: "kit_1_a" },
    { text: " takes one " },
    { name: "kitting:Starter" },
    { text: ", not kit_1_ab." },
  ]);
  const isHolding = (word: string) => word === "Holding";
  expect(namedIn("not Holding(g_1, kit_1_a) (yet), but kit_1_a(x)", [], isElement, isHolding)).toEqual([
    { text: "not " },
    { condition: "Holding(g_1, kit_1_a)" },
    { text: " (yet), but " },
    { name: "kit_1_a" },
    { text: "(x)" },
  ]);
  expect(namedIn("nobody can", [], isElement)).toEqual([{ text: "nobody can" }]);
  expect(namedIn("", ["a"], isElement)).toEqual([]);
});

test("a cause of an unknown kind, or without a core, shows its whole text", () => {
  const cause = causeOf({ kind: "bad weather", text: "It rains.", elements: [1, "hall"] });
  expect(cause).toEqual({ kind: null, text: "It rains.", why: "It rains.", conditions: [], named: ["hall"] });
});
