import { ApiProblem } from "../../api/client";
import { refusalOf } from "./refusals";

const POSE = "body.properties.sk:pose";
const draft = { "rdfs:label": "starter", "sk:placement": null, "sk:pose": "far away", "sk:mass": 1 };

function refused(errors: { field: string; message: string }[], detail = "a dump") {
  const details = { type: "", title: "Invalid request", status: 422, detail, code: "", instance: "", errors };
  return refusalOf(new ApiProblem(422, details as never), draft, (value) => `not accepted: ${String(value)}`);
}

test("of a value that may have several forms, only what is wrong with the one that was meant is said", () => {
  const { byField, rest } = refused([
    { field: `${POSE}.bool`, message: "Input should be a valid boolean" },
    { field: `${POSE}.GivenPose.position.0`, message: "Input should be greater than or equal to -1000000" },
    { field: `${POSE}.list[float]`, message: "Input should be a valid list" },
  ]);
  expect(byField).toEqual({ "sk:pose": "x: Input should be greater than or equal to -1000000" });
  expect(rest).toEqual([]);
});

test("a value that no form fits is not accepted", () => {
  const { byField } = refused([
    { field: `${POSE}.bool`, message: "Input should be a valid boolean" },
    { field: `${POSE}.int`, message: "Input should be a valid integer" },
  ]);
  expect(byField).toEqual({ "sk:pose": "not accepted: far away" });
});

test("a name has its own field; what is about none is said besides", () => {
  const { byField, rest } = refused([
    { field: "body.label", message: "String should have at most 200 characters" },
    { field: "body.reason", message: "too long" },
  ]);
  expect(byField).toEqual({ "rdfs:label": "String should have at most 200 characters" });
  expect(rest).toEqual(["reason: too long"]);
});

test("a refusal in words is sorted by the fields that it names", () => {
  const { byField, rest } = refused([], "the change was refused:\n- sk:mass must be positive\n- the pallet is full");
  expect(byField).toEqual({ "sk:mass": "sk:mass must be positive" });
  expect(rest).toEqual(["the pallet is full"]);
});
