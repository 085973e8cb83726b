import { changeLines, shown } from "./changes";

test("each edit of each change is one line with the name of its element", () => {
  const place = (relation: string, where: string) => ({ relation, place: where });
  const lines = changeLines([
    {
      number: 4,
      edits: [
        { edit: "placement", element: "robot_1", old: place("sk:at", "floor"), new: place("sk:at", "pallet_a") },
        { edit: "property", element: "robot_1", property: "sk:mass", old: null, new: 1.00004 },
      ],
    },
  ]);
  expect(lines.map(({ element, text }) => [element, text])).toEqual([
    ["robot_1", "at floor → at pallet_a"],
    ["robot_1", "mass: – → 1.00004"],
  ]);
  expect(new Set(lines.map(({ key }) => key)).size).toBe(2);
});

test("a change without edits makes no line, and poses are shortened", () => {
  expect(changeLines([{ number: 1 }])).toEqual([]);
  expect(shown({ position: [1, 0.12345678, 0], orientation: [0, 0, 0, 1] })).toBe("1, 0.1235, 0 m");
});
