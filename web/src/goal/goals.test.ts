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

test("a sentence becomes structured data, negated where it says so", () => {
  const [row] = keyed([{ kind: "word", word: "InKit", arguments: ["kitting:Starter", "kit_1"], not: true }]);
  expect(row && goalOf(row)).toEqual({ not: IN_KIT });
});

test("a goal with an empty slot or an empty text is no order", () => {
  expect(goalOrder(keyed([{ kind: "word", word: "InKit", arguments: [null, "kit_1"], not: false }]))).toBeNull();
  expect(goalOrder(keyed([{ kind: "text", text: "  " }]))).toBeNull();
  expect(goalOrder([])).toBeNull();
});

test("what the server understands as one word is a sentence again, all else stays text", () => {
  expect(rowOf(checked("", IN_KIT))).toMatchObject({ kind: "word", word: "InKit", not: false });
  expect(rowOf(checked("", { not: IN_KIT }))).toMatchObject({ kind: "word", word: "InKit", not: true });
  expect(rowOf(checked("for all …", FOR_ALL))).toEqual({ kind: "text", text: "for all …" });
});

test("names with blanks or quotes are quoted in text", () => {
  const row = { kind: "word", word: "InKit", arguments: ['a "b" c', "kit_1"], not: true } as const;
  expect(textOf({ ...row, arguments: [...row.arguments] })).toBe(String.raw`not InKit("a \"b\" c", kit_1)`);
});

test("conditions are the same whether or not they say the prefix of an ontology", () => {
  expect(isSame("not InKit(kitting:Starter, kit_1)", "not InKit(Starter, kit_1)")).toBe(true);
  expect(isSame("for all c: kitting:Compartment (A(c))", "for all c: Compartment (A(c))")).toBe(true);
  expect(isSame("InKit(Starter, kit_1)", "InKit(Starter, kit_2)")).toBe(false);
});

test("giving up a condition leaves the others", () => {
  const conditions = [
    checked("InKit(kitting:Starter, kit_1)", IN_KIT),
    checked("A(x)", { condition: "A", arguments: ["x"] }),
  ];
  expect(repaired(conditions, { without: ["InKit(Starter, kit_1)"], instead: [] })).toEqual([
    { kind: "word", word: "A", arguments: ["x"], not: false },
  ]);
});

test("wanting a condition otherwise keeps the names of classes whole, and the others as they are", () => {
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

test("a proposal about what is not wanted any more cannot be taken", () => {
  expect(repaired([], { without: ["A(x)"], instead: [] })).toBeNull();
});

test("a condition as the server writes it is read as a sentence, and what is more than one word stays text", () => {
  const word = { kind: "word", word: "ObjectAtLocation", arguments: ["kitting:Starter", "kit_1_a"], not: true };
  expect(readRow("not ObjectAtLocation(kitting:Starter, kit_1_a)")).toEqual(word);
  const all = "for all c: Compartment (not LocationEmpty(c))";
  expect(readRow(all)).toEqual({ kind: "text", text: all });
});

test("why a condition does not hold is told without the condition itself", () => {
  const text = "InKit(kitting:Starter, kit_1)";
  expect(whyAlone({ text, why: "InKit(Starter, kit_1): no Starter makes it true" })).toBe("no Starter makes it true");
  expect(whyAlone({ text, why: "it lies elsewhere" })).toBe("it lies elsewhere");
});
