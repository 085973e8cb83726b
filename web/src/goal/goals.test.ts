import {
  type CheckedCondition,
  goalOf,
  goalOrder,
  isSame,
  keyed,
  readRow,
  repaired,
  rowOf,
  textOf,
  whyAlone,
} from "./goals";

const IN_KIT = { condition: "InKit", arguments: ["kitting:Starter", "kit_1"] };
const FOR_ALL = { for_all: "c", class: "kitting:Compartment", holds: IN_KIT };

function checked(text: string, data: Record<string, unknown>): CheckedCondition {
  return { text, data, holds: false, why: "", lines: [] };
}

test("a sentence becomes structured data, with its negation", () => {
  const [row] = keyed([{ kind: "word", word: "InKit", arguments: ["kitting:Starter", "kit_1"], not: true }]);
  expect(row && goalOf(row)).toEqual({ not: IN_KIT });
});

test("a goal with an empty slot or text makes no order", () => {
  expect(goalOrder(keyed([{ kind: "word", word: "InKit", arguments: [null, "kit_1"], not: false }]))).toBeNull();
  expect(goalOrder(keyed([{ kind: "text", text: "  " }]))).toBeNull();
  expect(goalOrder([])).toBeNull();
});

test("a parsed condition of one word becomes a sentence, others stay text", () => {
  expect(rowOf(checked("", IN_KIT))).toMatchObject({ kind: "word", word: "InKit", not: false });
  expect(rowOf(checked("", { not: IN_KIT }))).toMatchObject({ kind: "word", word: "InKit", not: true });
  expect(rowOf(checked("for all …", FOR_ALL))).toEqual({ kind: "text", text: "for all …" });
});

test("names with blanks or quotes are quoted in the text", () => {
  const row = { kind: "word", word: "InKit", arguments: ['a "b" c', "kit_1"], not: true } as const;
  expect(textOf({ ...row, arguments: [...row.arguments] })).toBe(String.raw`not InKit("a \"b\" c", kit_1)`);
});

test("conditions are equal with and without prefix", () => {
  expect(isSame("not InKit(kitting:Starter, kit_1)", "not InKit(Starter, kit_1)")).toBe(true);
  expect(isSame("for all c: kitting:Compartment (A(c))", "for all c: Compartment (A(c))")).toBe(true);
  expect(isSame("InKit(Starter, kit_1)", "InKit(Starter, kit_2)")).toBe(false);
});

test("giving up a condition keeps the others", () => {
  const conditions = [
    checked("InKit(kitting:Starter, kit_1)", IN_KIT),
    checked("A(x)", { condition: "A", arguments: ["x"] }),
  ];
  expect(repaired(conditions, { without: ["InKit(Starter, kit_1)"], instead: [] })).toEqual([
    { kind: "word", word: "A", arguments: ["x"], not: false },
  ]);
});

test("replacing a condition keeps the prefixes of its classes and the other conditions", () => {
  const conditions = [
    checked("InKit(kitting:Starter, kit_1)", IN_KIT),
    checked("A(x)", { condition: "A", arguments: ["x"] }),
  ];
  const instead = [{ condition: "InKit(Starter, kit_1)", by: "InKit(Starter, kit_2)" }];
  expect(repaired(conditions, { without: [], instead })).toEqual([
    { kind: "word", word: "InKit", arguments: ["kitting:Starter", "kit_2"], not: false },
    { kind: "word", word: "A", arguments: ["x"], not: false },
  ]);
});

test("a proposal about a condition that is no longer in the goal cannot be applied", () => {
  expect(repaired([], { without: ["A(x)"], instead: [] })).toBeNull();
});

test("a condition in the server's notation becomes a sentence, others than single words stay text", () => {
  const word = { kind: "word", word: "ObjectAtLocation", arguments: ["kitting:Starter", "kit_1_a"], not: true };
  expect(readRow("not ObjectAtLocation(kitting:Starter, kit_1_a)")).toEqual(word);
  const all = "for all c: Compartment (not LocationEmpty(c))";
  expect(readRow(all)).toEqual({ kind: "text", text: all });
});

test("the reason of a condition does not repeat the condition itself", () => {
  const text = "InKit(kitting:Starter, kit_1)";
  expect(whyAlone({ text, why: "InKit(Starter, kit_1): no Starter makes it true" })).toBe("no Starter makes it true");
  expect(whyAlone({ text, why: "it lies elsewhere" })).toBe("it lies elsewhere");
});
