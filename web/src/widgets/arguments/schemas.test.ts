import dumped from "./parameters.testdata.json";
import { argumentFaults, inputKind, type Parameter, shapeOf, shownParameters, withArgument, within } from "./schemas";

/** The parameters of all modules of the kitting scene. */
const MODULES = dumped as unknown as Record<string, Parameter[]>;
const all = Object.values(MODULES).flat();

function parameter(module: string, key: string): Parameter {
  const found = MODULES[module]?.find((one) => one.key === key);
  if (found === undefined) throw new Error(`${module} has no ${key}`);
  return found;
}

function made(json_schema: Record<string, unknown>, type = "Thing"): Parameter {
  return { key: "it", type, kind: "online", help: "", unit: "", required: true, planning: false, json_schema };
}

test("every parameter of every module has its own input, none needs raw JSON", () => {
  expect(all.length).toBeGreaterThan(50);
  expect(all.filter((one) => inputKind(shapeOf(one)) === "json")).toEqual([]);
});

test.each([
  ["pick", "Object", "element"],
  ["teach_grasp", "type", "class"],
  ["choose", "question", "text"],
  ["choose", "options", "texts"],
  ["refill", "count", "integer"],
  ["gripper_control", "gap", "number"],
  ["jog_joints", "deltas", "numbers"],
  ["jog_tool", "translation", "vector"],
])("%s: %s is said by %s", (module, key, kind) => {
  expect(inputKind(shapeOf(parameter(module, key)))).toBe(kind);
});

test("six numbers are a pose only if the parameter says so", () => {
  const six = { type: "array", items: { type: "number" }, minItems: 6, maxItems: 6 };
  expect(inputKind(shapeOf(made(six, "pose")))).toBe("pose");
  expect(inputKind(shapeOf(made(six, "number")))).toBe("vector");
});

test("parameters for planning are hidden, and required ones come first", () => {
  for (const parameters of Object.values(MODULES)) {
    const { said, spare } = shownParameters(parameters);
    expect([...said, ...spare].some((one) => one.planning)).toBe(false);
    expect(said.length + spare.length).toBe(parameters.filter((one) => !one.planning).length);
  }
  expect(shownParameters(MODULES["pick"] ?? []).said.map((one) => one.key)).toEqual(["Container", "Object"]);
});

test("defaults and omitted values are valid", () => {
  for (const one of all) {
    expect(argumentFaults([one], {})).toEqual({});
    expect(argumentFaults([one], { [one.key]: one.default ?? null })).toEqual({});
  }
});

test("partial vectors, malformed numbers and numbers beyond a limit are faults", () => {
  const translation = parameter("jog_tool", "translation");
  expect(argumentFaults([translation], { translation: [1, null, 3] })["translation"]?.keyword).toBe("type");
  expect(argumentFaults([translation], { translation: [1, 2] })["translation"]).toMatchObject({
    keyword: "minItems",
    limit: 3,
  });
  const deltas = parameter("jog_joints", "deltas");
  expect(argumentFaults([deltas], { deltas: [0.1, "a"] })["deltas"]?.keyword).toBe("type");
  const limited = made({ type: "number", minimum: 0, maximum: 2 }, "number");
  expect(argumentFaults([limited], { it: 3 })["it"]).toMatchObject({ keyword: "maximum", limit: 2 });
});

describe("a value of a plug-in's own class", () => {
  const way = made({
    type: "object",
    properties: {
      speed: { type: "number" },
      gait: { $ref: "#/$defs/Gait" },
      rest: { anyOf: [{ type: "integer" }, { type: "null" }] },
    },
    required: ["speed"],
    $defs: { Gait: { enum: ["walk", "run"] } },
  });

  test("has fields, with references and optional values resolved", () => {
    const shape = shapeOf(way);
    expect(inputKind(shape)).toBe("object");
    const properties = shape.schema.properties as Record<string, object>;
    const kinds = Object.values(properties).map((part) => inputKind(within(shape, part, "")));
    expect(kinds).toEqual(["number", "choice", "integer"]);
  });

  test("is at fault if a field is missing or wrong", () => {
    expect(argumentFaults([way], { it: { gait: "walk" } })["it"]?.keyword).toBe("required");
    expect(argumentFaults([way], { it: { speed: 1, gait: "fly" } })["it"]?.keyword).toBe("enum");
    expect(argumentFaults([way], { it: { speed: 1, gait: "run", rest: null } })).toEqual({});
  });
});

test("a cleared value is omitted", () => {
  expect(withArgument({ a: 1, b: 2 }, "a", undefined)).toEqual({ b: 2 });
  expect(withArgument({ a: 1 }, "b", null)).toEqual({ a: 1, b: null });
});
