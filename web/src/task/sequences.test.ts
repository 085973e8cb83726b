import { type Conflict, edited, fateOf, onto, type Sequence, sequenceOf } from "./sequences";

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

test("an outdated edit is applied to the intended step at its current position", () => {
  const removal = conflict({ kind: "remove", at: 1 }, ["pallet_b", "pallet_a", "kit_1"]);
  expect(onto(removal)).toEqual({ kind: "remove", at: 2 });
});

test("an edit of a step that another person has changed or removed cannot be applied", () => {
  expect(onto(conflict({ kind: "move", at: 0, to: 1 }, ["kit_1"]))).toBeNull();
});

test("steps are never inserted behind the end", () => {
  expect(onto(conflict({ kind: "insert", at: 2, step: STEP }, ["kit_1"]))).toEqual({
    kind: "insert",
    at: 1,
    step: STEP,
  });
});

test("the step of an open form is found where another person moved it; of several, the nearest", () => {
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

test("a step changed or removed by another person is reported as such", () => {
  expect(fateOf({ seen: SEEN, at: 0 }, sequence(2, ["pallet_b", "kit_1"]))).toEqual({ fate: "changed", at: 0 });
  expect(fateOf({ seen: SEEN, at: 0 }, sequence(2, ["kit_1"]))).toEqual({ fate: "removed" });
});

test("a changed step is found even if steps were added or it was moved", () => {
  const three = sequence(1, ["pallet_a", "kit_1", "kit_2"]);
  const appended = sequence(2, ["pallet_b", "kit_1", "kit_2", "kit_3"]);
  expect(fateOf({ seen: three, at: 0 }, appended)).toEqual({ fate: "changed", at: 0 });
  const before = sequence(2, ["kit_3", "pallet_a", "pallet_b", "kit_2"]);
  expect(fateOf({ seen: three, at: 1 }, before)).toEqual({ fate: "changed", at: 2 });
});

test("a step that takes the place of a removed one is not mistaken for a changed one", () => {
  const three = sequence(1, ["pallet_a", "kit_1", "kit_2"]);
  const appended = sequence(2, ["kit_1", "kit_2", "pallet_b"]);
  expect(fateOf({ seen: three, at: 0 }, appended)).toEqual({ fate: "removed" });
  expect(fateOf({ seen: three, at: 1 }, sequence(2, ["pallet_a", "kit_2", "pallet_b"]))).toEqual({ fate: "removed" });
  const twice = sequence(1, ["kit_1", "pallet_a", "kit_1"]);
  expect(fateOf({ seen: twice, at: 1 }, sequence(2, ["kit_1", "kit_1", "kit_1"]))).toEqual({ fate: "removed" });
});

test("a sequence is a document with the problems and the subsystem of each step", () => {
  const document = {
    kind: "sequence",
    id: "round",
    revision: 7,
    module: "sequence:round",
    data: { title: "Round", steps: [{ skill: "drive" }, { skill: "place", arguments: { Object: "starter_1" } }] },
    problems: [{ place: "steps[1]", text: "nothing is held" }],
    agents: { "steps[0]": "base_1", "steps[1]": "arm_1" },
  };
  const shown = sequenceOf(document);
  expect(shown).toMatchObject({ id: "round", title: "Round", version: 7, count: 2, works: false });
  expect(shown.steps.map(({ agent, works, problems }) => ({ agent, works, problems }))).toEqual([
    { agent: "base_1", works: true, problems: [] },
    { agent: "arm_1", works: false, problems: ["nothing is held"] },
  ]);
});

test("an edit is applied to the displayed steps", () => {
  const steps = ["a", "b", "c"].map((Location) => ({ skill: "drive", arguments: { Location } }));
  const places = (edit: Parameters<typeof edited>[1]) => edited(steps, edit).map((step) => step.arguments?.Location);
  expect(places({ kind: "insert", at: 1, step: STEP })).toEqual(["a", "pallet_b", "b", "c"]);
  expect(places({ kind: "change", at: 0, step: STEP })).toEqual(["pallet_b", "b", "c"]);
  expect(places({ kind: "remove", at: 2 })).toEqual(["a", "b"]);
  expect(places({ kind: "move", at: 0, to: 2 })).toEqual(["b", "c", "a"]);
});
