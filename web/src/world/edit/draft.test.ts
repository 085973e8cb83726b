import type { Details } from "../queries";
import { differences, draftOf, onTop, patchOf, reasons, unfitFields, without } from "./draft";

const before = { "rdfs:label": "starter", "sk:placement": { relation: "sk:in", place: "pallet_a" }, "sk:mass": 0.8 };

test("only own values can be edited: the draft omits those of the class", () => {
  const element = {
    label: "starter",
    placement: null,
    properties: { "sk:mass": { value: 0.8, origin: "class" }, "sk:missing": { value: true, origin: "own" } },
  } as unknown as Details;
  expect(draftOf(element)).toEqual({ "rdfs:label": "starter", "sk:placement": null, "sk:missing": true });
});

test("only changed fields are written", () => {
  expect(patchOf(before, { ...before, "sk:mass": 0.7 }, "weighed")).toEqual({
    properties: { "sk:mass": 0.7 },
    reason: "weighed",
  });
});

test("removing an own value sends null", () => {
  expect(patchOf(before, without(before, "sk:mass"), "")).toEqual({ properties: { "sk:mass": null }, reason: "" });
});

test("a pose without a frame is in the map, regardless of its former frame", () => {
  const pose = { position: [1, 2, 3], orientation: [0, 0, 0, 1] };
  const patch = patchOf({ "sk:pose": { ...pose, frame: "kit_1" } }, { "sk:pose": pose }, "");
  expect(patch.properties?.["sk:pose"]).toEqual({ ...pose, frame: null });
});

test("a missing frame equals the map frame", () => {
  const pose = { position: [1, 2, 3], orientation: [0, 0, 0, 1] };
  expect(patchOf({ "sk:pose": pose }, { "sk:pose": { ...pose, frame: null } }, "")).toEqual({ reason: "" });
});

test("a field conflicts only if both changed it to different values", () => {
  const theirs = { ...before, "rdfs:label": "theirs", "sk:mass": 0.9 };
  const mine = { ...before, "rdfs:label": "mine" };
  const found = differences(before, theirs, mine);
  expect(found.map(({ field, clash }) => [field, clash])).toEqual([
    ["rdfs:label", true],
    ["sk:mass", false],
  ]);
});

test("merging my changes keeps fields that only others changed", () => {
  const theirs = { ...before, "rdfs:label": "theirs", "sk:missing": true };
  const mine = without({ ...before, "rdfs:label": "mine" }, "sk:mass");
  expect(onTop(before, mine, theirs)).toEqual({
    "rdfs:label": "mine",
    "sk:placement": before["sk:placement"],
    "sk:missing": true,
  });
});

test("a refusal is shown at the field it names", () => {
  const detail =
    "transaction of ann refused:\n  - sk:mass of starter_1 needs a finite number, got 'x'\n  - no such place";
  expect(reasons(detail, ["rdfs:label", "sk:mass"])).toEqual({
    byField: { "sk:mass": "sk:mass of starter_1 needs a finite number, got 'x'" },
    rest: ["no such place"],
  });
});

test("a property whose name is a prefix of another does not get its refusal", () => {
  expect(reasons("sk:maxDepth must be positive", ["sk:max", "sk:maxDepth"]).byField).toEqual({
    "sk:maxDepth": "sk:maxDepth must be positive",
  });
});

test("a draft with missing or malformed numbers cannot be saved", () => {
  const pose = { position: [0, Number.NaN, 0], orientation: [0, 0, 0, 1] };
  expect(unfitFields({ ...before, "sk:pose": pose, "sk:graspWidth": Number.NaN, "sk:size": [1, 2] })).toEqual([
    "sk:pose",
    "sk:graspWidth",
  ]);
  expect(unfitFields(before)).toEqual([]);
});
