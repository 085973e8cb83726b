import { ApiProblem } from "../api/client";
import "../i18n";
import { learn } from "../i18n/sentences";
import { isUnanswered, problemText, problemTitle } from "./problems";

function problem(status: number, code: string, detail: string): ApiProblem {
  return new ApiProblem(status, { type: "", title: "", status, detail, code, instance: "", errors: [] } as never);
}

test("a request without an answer is not reported as refused", () => {
  expect(problemTitle(new TypeError("Failed to fetch"))).toMatch(/it is not known whether it was done/);
  expect(problemTitle(problem(502, "", "bad gateway"), "It was not loaded")).toMatch(/it is not known/);
  expect(problemTitle(problem(412, "StaleVersion", "changed"), "It was not loaded")).toBe("It was not loaded");
  expect(isUnanswered(problem(503, "Busy", "ask again later"))).toBe(false);
});

test("an unknown name is reported without the list of known names", () => {
  const known = { template: "Known: {names}.", values: { names: "a, b" } };
  const unknown = { template: "unknown {kind} '{name}'.", values: { kind: "element", name: "starter_3" } };
  const detail = "unknown element 'starter_3'. Known: a, b.";
  learn({ texts: { [detail]: { template: "{part0} {part1}", values: { part0: unknown, part1: known } } } });
  expect(problemText(problem(422, "UnknownName", detail))).toBe("unknown element 'starter_3'.");
  expect(problemText(problem(409, "WrongState", "halted. Known: why"))).toBe("halted. Known: why");
});

test("the end of a login is reported in words for people", () => {
  expect(problemText(problem(401, "KeyNeeded", "send it as 'Authorization: Bearer sk_…'"))).toMatch(/login has ended/);
});
