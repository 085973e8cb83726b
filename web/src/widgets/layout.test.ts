import { expect, test } from "vitest";
import { layOut } from "./Graph";

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
