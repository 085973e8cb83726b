import { type Conflict, fateOf, onto, type Sequence } from "./sequences";

function sequence(version: number, places: string[]): Sequence {
  const steps = places.map((Location) => {
    return { skill: "drive", arguments: { Location }, agent: "base_1", works: true, problems: [] };
  });
  return { id: "round", title: "", version, count: steps.length, works: true, steps };
}
const SEEN = sequence(1, ["pallet_a", "kit_1"]);
const STEP = { skill: "drive", arguments: { Location: "pallet_b" } };

function conflict(edit: Conflict["edit"], there: string[]): Conflict {
  return { edit, seen: SEEN, there: sequence(2, there) };
}

test("a change that came too late is made to the step that was meant, wherever it is by now", () => {
  const removal = conflict({ kind: "remove", at: 1 }, ["pallet_b", "pallet_a", "kit_1"]);
  expect(onto(removal)).toEqual({ kind: "remove", at: 2 });
});

test("a change of a step that somebody else has changed or removed cannot be made any more", () => {
  expect(onto(conflict({ kind: "move", at: 0, to: 1 }, ["kit_1"]))).toBeNull();
});

test("what is inserted never comes behind the end", () => {
  expect(onto(conflict({ kind: "insert", at: 2, step: STEP }, ["kit_1"]))).toEqual({
    kind: "insert",
    at: 1,
    step: STEP,
  });
});

test("a step whose form is open is found where somebody else moved it, the nearest of several", () => {
  expect(fateOf({ seen: SEEN, at: 1 }, sequence(2, ["pallet_b", "pallet_a", "kit_1"]))).toEqual({
    fate: "stays",
    at: 2,
  });
  const twice = sequence(1, ["kit_1", "pallet_a", "kit_1"]);
  expect(fateOf({ seen: twice, at: 2 }, sequence(2, ["kit_1", "pallet_a", "kit_1", "kit_1"]))).toEqual({
    fate: "stays",
    at: 2,
  });
});

test("a step that somebody else has changed or removed meanwhile is told to be so", () => {
  expect(fateOf({ seen: SEEN, at: 0 }, sequence(2, ["pallet_b", "kit_1"]))).toEqual({ fate: "changed", at: 0 });
  expect(fateOf({ seen: SEEN, at: 0 }, sequence(2, ["kit_1"]))).toEqual({ fate: "removed" });
});

test("a step that somebody else has changed is found though steps were added, and moved with them", () => {
  const three = sequence(1, ["pallet_a", "kit_1", "kit_2"]);
  const appended = sequence(2, ["pallet_b", "kit_1", "kit_2", "kit_3"]);
  expect(fateOf({ seen: three, at: 0 }, appended)).toEqual({ fate: "changed", at: 0 });
  const before = sequence(2, ["kit_3", "pallet_a", "pallet_b", "kit_2"]);
  expect(fateOf({ seen: three, at: 1 }, before)).toEqual({ fate: "changed", at: 2 });
});

test("another step that came to the place of a removed one is not what that was changed to", () => {
  const three = sequence(1, ["pallet_a", "kit_1", "kit_2"]);
  const appended = sequence(2, ["kit_1", "kit_2", "pallet_b"]);
  expect(fateOf({ seen: three, at: 0 }, appended)).toEqual({ fate: "removed" });
  expect(fateOf({ seen: three, at: 1 }, sequence(2, ["pallet_a", "kit_2", "pallet_b"]))).toEqual({ fate: "removed" });
  const twice = sequence(1, ["kit_1", "pallet_a", "kit_1"]);
  expect(fateOf({ seen: twice, at: 1 }, sequence(2, ["kit_1", "kit_1", "kit_1"]))).toEqual({ fate: "removed" });
});
