import "../i18n";
import { faultText } from "./faults";

const SAME = [
  ["minimum", "greater_than_equal"],
  ["exclusiveMinimum", "greater_than"],
  ["maximum", "less_than_equal"],
  ["exclusiveMaximum", "less_than"],
  ["minLength", "string_too_short"],
  ["maxLength", "string_too_long"],
  ["minItems", "too_short"],
  ["maxItems", "too_long"],
] as const;

test.each(SAME)("what a form finds (%s) is said as what the server finds (%s)", (keyword, kind) => {
  const said = faultText({ message: "of the validator", kind: keyword, limit: 3 });
  expect(said).toBe(faultText({ message: "of the server", kind, limit: 3 }));
  expect(said).toMatch(/\b3\b/);
});

test("a fault that the page has no words for is said as it was told", () => {
  expect(faultText({ message: "must be even", kind: "multipleOf", limit: 2 })).toBe("must be even");
});
