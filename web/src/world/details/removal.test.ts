import { removalIn } from "./removal";

const edit = { edit: "element", element: "starter_1", old: { id: "starter_1" }, new: null };
const change = (...edits: object[]) => ({ number: 5, author: "anna", edits }) as never;

test("the last change of an element shows who removed it", () => {
  expect(removalIn([change({ edit: "placement", element: "starter_1", new: null }, edit)], "starter_1")).toMatchObject({
    author: "anna",
  });
});

test("elements that were restored or replaced do not count as removed", () => {
  expect(removalIn([change({ ...edit, new: edit.old, old: null }), change(edit)], "starter_1")).toBeNull();
  expect(removalIn([change({ ...edit, element: "starter_2" })], "starter_1")).toBeNull();
  expect(removalIn([], "starter_1")).toBeNull();
});
