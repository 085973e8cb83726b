import { expect, test } from "vitest";
import { concerned, layOut, READABLE, viewOf } from "./Graph";

/** A tree: each node has so many children, level by level. */
function tree(counts: readonly (readonly number[])[]) {
  const [ids, edges, rows] = [["root"], [] as { from: string; to: string }[], [["root"]]];
  for (const row of counts) {
    const above = rows.at(-1) ?? [];
    const below = above.flatMap((parent, index) =>
      Array.from({ length: row[index] ?? 0 }, (_, n) => [parent, `${parent}/${n}`]),
    );
    for (const [from, to] of below as [string, string][]) {
      ids.push(to);
      edges.push({ from, to });
    }
    rows.push(below.map(([, to]) => to ?? ""));
  }
  return { ids, edges, rows };
}

const TREES = [
  [[3], [0, 2, 1]],
  [[2], [4, 1], [0, 3, 1, 0, 2]],
  [[5], [1, 0, 4, 0, 2], [2, 0, 1, 3, 0, 0, 1]],
  [[12], [0, 3, 0, 2, 1, 0, 0, 0, 5, 0, 1, 2]],
];

test.each(TREES)("children are drawn in the order in which they run: %j", (...counts) => {
  const { ids, edges, rows } = tree(counts);
  for (const [direction, axis] of [
    ["down", "x"],
    ["right", "y"],
  ] as const) {
    const places = layOut([ids, edges, direction]);
    for (const row of rows) {
      const drawn = row.toSorted((one, other) => (places.get(one)?.[axis] ?? 0) - (places.get(other)?.[axis] ?? 0));
      expect(drawn).toEqual(row);
    }
  }
});

const PANE = { width: 360, height: 400 };

test.each([12, 120])("of %i nodes in a column, the one in question is in view, with readable text", (count) => {
  const bounds = { x: 0, y: 0, width: 190, height: count * 96 };
  for (const at of [0, Math.floor(count / 2), count - 1]) {
    const { x, y, zoom } = viewOf(bounds, PANE, { x: 95, y: at * 96 + 31 });
    expect(zoom).toBeGreaterThanOrEqual(READABLE);
    const [left, top] = [x, zoom * at * 96 + y];
    expect(left).toBeGreaterThanOrEqual(0);
    expect(left + zoom * 190).toBeLessThanOrEqual(PANE.width);
    expect(top).toBeGreaterThanOrEqual(0);
    expect(top + zoom * 62).toBeLessThanOrEqual(PANE.height);
  }
});

test("a graph that fits is shown as a whole, in its own size", () => {
  expect(viewOf({ x: 0, y: 0, width: 200, height: 300 }, PANE, { x: 0, y: 0 })).toEqual({ x: 80, y: 50, zoom: 1 });
});

test("looked at is what runs, then what is chosen, then what ran last", () => {
  const node = (id: string, mood: "good" | "running" | "waiting") => ({ id, title: id, state: { mood, text: mood } });
  const root = node("task", "running");
  expect(concerned([root, node("a", "good"), node("b", "running"), node("c", "waiting")], "a")).toEqual(["b"]);
  expect(concerned([root, node("a", "good"), node("b", "good"), node("c", "waiting")], "a")).toEqual(["a"]);
  expect(concerned([root, node("a", "good"), node("b", "good"), node("c", "waiting")], null)).toEqual(["b"]);
  expect(concerned([root, node("a", "waiting")], null)).toEqual(["task"]);
});
