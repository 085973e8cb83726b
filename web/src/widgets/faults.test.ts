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

test.each(SAME)("a fault found by the form (%s) has the same text as one found by the server (%s)", (keyword, kind) => {
  const said = faultText({ message: "of the validator", kind: keyword, limit: 3 });
  expect(said).toBe(faultText({ message: "of the server", kind, limit: 3 }));
  expect(said).toMatch(/\b3\b/);
});

test("a fault without a translation shows the server's text", () => {
  expect(faultText({ message: "must be even", kind: "multipleOf", limit: 2 })).toBe("must be even");
});
