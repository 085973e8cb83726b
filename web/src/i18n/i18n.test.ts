import * as de from "./de";
import * as en from "./en";

function paths(node: unknown, prefix = ""): string[] {
  if (typeof node !== "object" || node === null) return [prefix];
  return Object.entries(node).flatMap(([key, value]) => paths(value, prefix ? `${prefix}.${key}` : key));
}

test("German has exactly the keys of English", () => {
  expect(paths(de).sort()).toEqual(paths(en).sort());
});
