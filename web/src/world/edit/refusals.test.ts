import { ApiProblem } from "../../api/client";
import { refusalOf } from "./refusals";

const POSE = "body.properties.sk:pose";
const draft = { "rdfs:label": "starter", "sk:placement": null, "sk:pose": "far away", "sk:mass": 1 };

function refused(errors: { field: string; message: string; kind?: string; limit?: number }[], detail = "a dump") {
  const details = { type: "", title: "Invalid request", status: 422, detail, code: "", instance: "", errors };
  return refusalOf(new ApiProblem(422, details as never), draft, (field) => `not accepted: ${field}`);
}

test("if several forms of a value are refused, only the faults of the intended one are shown", () => {
  const { byField, rest } = refused([
    { field: `${POSE}.bool`, message: "must be true or false" },
    { field: `${POSE}.GivenPose.position.0`, message: "is too little", kind: "greater_than_equal", limit: -1000000 },
    { field: `${POSE}.list[float]`, message: "must be a list" },
  ]);
  expect(byField).toEqual({ "sk:pose": "x: must be at least -1000000" });
  expect(rest).toEqual([]);
});

test("a value that matches no form is refused as a whole", () => {
  const { byField } = refused([
    { field: `${POSE}.bool`, message: "must be true or false" },
    { field: `${POSE}.int`, message: "must be a whole number" },
  ]);
  expect(byField).toEqual({ "sk:pose": "not accepted: sk:pose" });
});

test("faults of the name belong to its field; others without a field are shown separately", () => {
  const { byField, rest } = refused([
    { field: "body.label", message: "must have at most 200 characters" },
    { field: "body.reason", message: "too long" },
  ]);
  expect(byField).toEqual({ "rdfs:label": "must have at most 200 characters" });
  expect(rest).toEqual(["reason: too long"]);
});

test("a refusal as text is assigned to the fields it names", () => {
  const { byField, rest } = refused([], "the change was refused:\n- sk:mass must be positive\n- the pallet is full");
  expect(byField).toEqual({ "sk:mass": "sk:mass must be positive" });
  expect(rest).toEqual(["the pallet is full"]);
});
