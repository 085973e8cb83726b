import { curl } from "../widgets/shell";
import { ghostsOf } from "./ghosts";
import { withPart } from "./KitTable";
import { keyFor } from "./order";

test("an unanswered order keeps its key, another order gets its own", () => {
  const pending = { key: "k", body: "a" };
  expect(keyFor("a", pending)).toBe("k");
  expect(keyFor("b", pending)).not.toBe("k");
  expect(keyFor("a", null)).not.toBe(keyFor("a", null));
});

test("a shell command preserves quotes in names", () => {
  expect(curl("http://x/api/v1/jobs", { goal: "it's" }, false)).toContain(String.raw`-d '{"goal":"it'\''s"}'`);
});

test("ghosts stand for objects that are not at their place yet", () => {
  const data = { condition: "InKit", arguments: ["kitting:Starter", "kit_1"] };
  expect(ghostsOf([{ data, holds: false }])).toEqual([{ key: "goal-0", like: "kitting:Starter", place: "kit_1" }]);
  expect(ghostsOf([{ data, holds: true }])).toEqual([]);
  expect(ghostsOf([{ data: { not: data }, holds: false }])).toEqual([]);
});

test("the table of a kit changes one condition for each place", () => {
  const one = withPart([], "kit_1_a", "kitting:Starter");
  const other = withPart(one, "kit_1_a", "starter_1");
  expect(other.map((row) => row.kind === "word" && row.arguments)).toEqual([["starter_1", "kit_1_a"]]);
  expect(other[0]?.key).toBe(one[0]?.key);
  expect(withPart(other, "kit_1_a", null)).toEqual([]);
});
