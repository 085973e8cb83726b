import {
  changeTemplate,
  EMPTY,
  fieldsOf,
  isCounted,
  notifyTemplate,
  reverseTemplate,
  templateOrder,
  useTemplateChanges,
  variablesOf,
  withPlaceholders,
  isTemplateName,
} from "./templates";

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

test("changes of templates are taken back and made again one by one", async () => {
  const there = new Map<string, { revision: number; data: unknown }>();
  let revisions = 1;
  vi.stubGlobal("fetch", async (request: Request) => {
    const id = decodeURIComponent(request.url.split("/").at(-1) ?? "");
    const seen = request.headers.get("if-match");
    expect(seen).toBe(there.has(id) ? `"${there.get(id)?.revision}"` : null);
    if (request.method === "DELETE") {
      there.delete(id);
      return new Response(null, { status: 204 });
    }
    const { data } = (await request.json()) as { data: unknown };
    there.set(id, { revision: revisions++, data });
    return Response.json({ kind: "template", id, revision: there.get(id)?.revision, module: "", data, problems: [] });
  });
  const go = async (count: number) => {
    await reverseTemplate(count);
    useTemplateChanges.setState({ count });
    return there.get("fill")?.data;
  };
  notifyTemplate("saved", await changeTemplate("fill", null, CONTENT));
  const seen = { name: "fill", version: there.get("fill")?.revision ?? 0, content: CONTENT };
  const replaced = { ...CONTENT, description: "another one" };
  notifyTemplate("replaced", await changeTemplate("fill", seen, replaced));
  expect(await go(1)).toEqual(CONTENT);
  expect(await go(2)).toEqual(replaced);
  expect(await go(1)).toEqual(CONTENT);
  expect(await go(0)).toBeUndefined();
  expect(await go(1)).toEqual(CONTENT);
  vi.unstubAllGlobals();
});
