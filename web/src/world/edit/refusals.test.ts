import { ApiProblem } from "../../api/client";
import { refusalOf } from "./refusals";

const POSE = "body.properties.sk:pose";
const draft = { "rdfs:label": "starter", "sk:placement": null, "sk:pose": "far away", "sk:mass": 1 };

function refused(errors: { field: string; message: string; kind?: string; limit?: number }[], detail = "a dump") {
  const details = { type: "", title: "Invalid request", status: 422, detail, code: "", instance: "", errors };
  return refusalOf(new ApiProblem(422, details as never), draft, (field) => `not accepted: ${field}`);
}

test("of a value that may have several forms, only what is wrong with the one that was meant is said", () => {
  const { byField, rest } = refused([
    { field: `${POSE}.bool`, message: "must be true or false" },
    { field: `${POSE}.GivenPose.position.0`, message: "is too little", kind: "greater_than_equal", limit: -1000000 },
    { field: `${POSE}.list[float]`, message: "must be a list" },
  ]);
  expect(byField).toEqual({ "sk:pose": "x: must be at least -1000000" });
  expect(rest).toEqual([]);
});

test("a value that no form fits is not accepted", () => {
  const { byField } = refused([
    { field: `${POSE}.bool`, message: "must be true or false" },
    { field: `${POSE}.int`, message: "must be a whole number" },
  ]);
  expect(byField).toEqual({ "sk:pose": "not accepted: sk:pose" });
});

test("a name has its own field; what is about none is said besides", () => {
  const { byField, rest } = refused([
    { field: "body.label", message: "must have at most 200 characters" },
    { field: "body.reason", message: "too long" },
  ]);
  expect(byField).toEqual({ "rdfs:label": "must have at most 200 characters" });
  expect(rest).toEqual(["reason: too long"]);
});

test("a refusal in words is sorted by the fields that it names", () => {
  const { byField, rest } = refused([], "the change was refused:\n- sk:mass must be positive\n- the pallet is full");
  expect(byField).toEqual({ "sk:mass": "sk:mass must be positive" });
  expect(rest).toEqual(["the pallet is full"]);
});
