import { EMPTY, fieldsOf, isCounted, templateOrder, variablesOf, withPlaceholders, isTemplateName } from "./templates";

const WORDS = [
  {
    name: "ObjectAtLocation",
    help: "",
    abstract: true,
    skills: [],
    roles: [
      { name: "object", class: "sk:Manipulatable", reached: "sk:Manipulatable" },
      { name: "location", class: "sk:Container", reached: "sk:Container" },
    ],
  },
];
const CONTENT = {
  description: "",
  parameters: [{ name: "kit", class: "Kit", description: "", default: null }],
  goal: [],
  per_material: { condition: "ObjectAtLocation", arguments: [{ material: "class" }, { material: "location" }] },
};
const ROW = { ...EMPTY, class: "kitting:Starter", location: "kit_1_a" };

test("the table has the fields that the template uses, and counts pieces only if they need not be told apart", () => {
  expect(fieldsOf(CONTENT)).toEqual(["class", "location"]);
  expect(isCounted(["class", "location"])).toBe(false);
  expect(isCounted(["class", "lot"])).toBe(true);
});

test("a template makes no order before its parameters and all rows are filled in", () => {
  const filled = { name: "fill", parameters: { kit: "kit_1" }, materials: [ROW] };
  expect(templateOrder(filled, CONTENT)).toMatchObject({ work_master: "fill", parameters: { kit: "kit_1" } });
  expect(templateOrder({ ...filled, parameters: {} }, CONTENT)).toBeNull();
  expect(templateOrder({ ...filled, materials: [] }, CONTENT)).toBeNull();
  expect(templateOrder({ ...filled, materials: [{ ...ROW, location: "" }] }, CONTENT)).toBeNull();
});

test("a row without a part has no effect", () => {
  const filled = { name: "fill", parameters: { kit: "kit_1" }, materials: [ROW, { ...EMPTY, location: "kit_1_b" }] };
  expect(templateOrder(filled, CONTENT)?.materials.map(({ location }) => location)).toEqual(["kit_1_a"]);
});

test("elements can become parameters, named after their roles; classes remain", () => {
  const conditions = ["kit_1_a", "kit_1_b"].map((place) => ({
    data: { condition: "ObjectAtLocation", arguments: ["kitting:Starter", place] },
    text: "",
    holds: false,
    why: "",
    lines: [],
  }));
  const variables = variablesOf(conditions, WORDS);
  expect(variables.map(({ id, name }) => [id, name])).toEqual([
    ["kit_1_a", "location"],
    ["kit_1_b", "location_2"],
  ]);
  expect(withPlaceholders({ not: conditions[0]?.data }, variables)).toEqual({
    not: { condition: "ObjectAtLocation", arguments: ["kitting:Starter", { parameter: "location" }] },
  });
});

test.each([
  ["kit für Halle 7-3", true],
  ["v1.2 (neu) 100 %", true],
  ["kit für Halle 7/3", false],
  ["../../etc/passwd", false],
  ["..", false],
])("%j may be the name of a template: %s", (name, may) => {
  expect(isTemplateName(name)).toBe(may);
});
