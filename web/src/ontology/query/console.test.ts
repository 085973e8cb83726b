import { columns, history, placeOf, remember, sorted } from "./console";

beforeEach(() => localStorage.clear());

test("the position of an error is parsed from the server's message", () => {
  expect(placeOf("the query does not parse: line 3: expected one of")).toEqual({ line: 3, column: 1 });
  expect(placeOf("error at line 2, column 14")).toEqual({ line: 2, column: 14 });
  expect(placeOf("it took longer than 5 s")).toBeNull();
});

test("the history lists a repeated query once, first, and keeps twenty", () => {
  for (let index = 0; index < 30; index++) remember(`ASK { ${index} }`);
  remember("ASK { 25 }");
  expect(history()).toHaveLength(20);
  expect(history()[0]).toBe("ASK { 25 }");
  expect(history().filter((one) => one === "ASK { 25 }")).toHaveLength(1);
});

test("a corrupt history counts as empty", () => {
  localStorage.setItem("skiros-queries", "{");
  expect(history()).toEqual([]);
});

test("the columns of SELECT * are in the order of the query", () => {
  expect(columns("SELECT * WHERE { ?s ?p ?o }", ["o", "p", "s"])).toEqual(["s", "p", "o"]);
  expect(columns("select distinct * { ?thing sk:in ?t }", ["t", "thing"])).toEqual(["thing", "t"]);
  expect(columns("SELECT ?o ?s WHERE { ?s ?p ?o }", ["o", "s"])).toEqual(["o", "s"]);
});

test("rows are sorted by numerical value, in both directions", () => {
  const rows = [{ n: 10 }, { n: -5 }, { n: 0.5 }, { n: -10 }, { n: 0.25 }, { n: 100 }];
  const rising = [-10, -5, 0.25, 0.5, 10, 100];
  expect(sorted(rows, { column: "n", falling: false }).map(({ n }) => n)).toEqual(rising);
  expect(sorted(rows, { column: "n", falling: true }).map(({ n }) => n)).toEqual(rising.toReversed());
  expect(sorted(rows, null)).toBe(rows);
});

test("names are sorted with their numbers in numerical order, and empty cells first", () => {
  const rows = [{ id: "part_10" }, { id: null }, { id: "part_2" }];
  expect(sorted(rows, { column: "id", falling: false }).map(({ id }) => id)).toEqual([null, "part_2", "part_10"]);
});
