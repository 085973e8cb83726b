import { added, MOST_ROWS, type OutputRow, rowOf } from "./output";
import { asCsv } from "./exports";

function row(number: number, more: Partial<OutputRow> = {}): OutputRow {
  const told = { kind: "module" as const, type: "running", subject: "pick", job: "", time: number, number };
  const data = { kind: "skill", agent: "arm_1", code: 1, text: "leg 1 of 2", caller: "" };
  return { ...rowOf({ ...told, id: `1f2e3d4c-${number}`, at: "2026-11-20T09:30:00Z", data }), ...more };
}

test("messages are in order and without duplicates, regardless of their source", () => {
  const rows = added([row(3), row(10)], [row(4), row(3), row(9)]);
  expect(rows.map(({ id }) => id)).toEqual(["1f2e3d4c-3", "1f2e3d4c-4", "1f2e3d4c-9", "1f2e3d4c-10"]);
});

test("only the latest messages are kept", () => {
  const many = Array.from({ length: MOST_ROWS + 5 }, (_, number) => row(number));
  expect(added([], many)).toHaveLength(MOST_ROWS);
  expect(added([], many)[0]?.id).toBe("1f2e3d4c-5");
});

test("a CSV table quotes special characters, and no cell begins with a formula", () => {
  const text = asCsv(
    ["module", "text"],
    [
      ["pick", 'a "b", c'],
      ["=1+1", "two\nlines"],
    ],
  );
  expect(text).toBe('module,text\r\npick,"a ""b"", c"\r\n\'=1+1,"two\nlines"\r\n');
});
