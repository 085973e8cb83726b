import { history, placeOf, remember } from "./console";

beforeEach(() => localStorage.clear());

test("the place of an error is read from what the server says", () => {
  expect(placeOf("the query does not parse: line 3: expected one of")).toEqual({ line: 3, column: 1 });
  expect(placeOf("error at line 2, column 14")).toEqual({ line: 2, column: 14 });
  expect(placeOf("it took longer than 5 s")).toBeNull();
});

test("what was asked before comes first once, and twenty are kept", () => {
  for (let index = 0; index < 30; index++) remember(`ASK { ${index} }`);
  remember("ASK { 25 }");
  expect(history()).toHaveLength(20);
  expect(history()[0]).toBe("ASK { 25 }");
  expect(history().filter((one) => one === "ASK { 25 }")).toHaveLength(1);
});

test("a broken history is an empty one", () => {
  localStorage.setItem("skiros-queries", "{");
  expect(history()).toEqual([]);
});
