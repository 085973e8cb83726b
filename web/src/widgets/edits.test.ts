import { editText } from "./edits";

const place = (relation: string, where: string) => ({ relation, place: where });

test.each([
  [{ edit: "placement", element: "p", old: place("sk:in", "a"), new: place("sk:heldBy", "g") }, "in a → held by g"],
  [{ edit: "property", element: "p", property: "sk:mass", old: null, new: { value: 1 } }, "mass: – → 1"],
  [{ edit: "relation", subject: "p", relation: "sk:hasA", object: "q", new: true }, "+ has q"],
  [{ edit: "element", element: "p", old: {}, new: null }, "removed"],
])("a change is told in words, without names of the ontology: %j", (edit, text) => {
  expect(editText(edit)).toEqual({ element: "p", text });
});

test("a pose is told as position and angles, not as a quaternion", () => {
  const pose = { position: [1, 0.12345678, 0], orientation: [0, 0, 1, 0] };
  const { text } = editText({ edit: "property", element: "p", property: "sk:pose", old: null, new: pose });
  expect(text).toBe("position: – → 1, 0.1235, 0 m; 0, 0, 180°");
});
