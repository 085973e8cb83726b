import { isUntouched, NEW, useDrafts } from "./draft";
import { keyed } from "./goals";

const ROWS = keyed([{ kind: "text", text: "InKit(relay_box_1, kit_1)" }]);

function draft() {
  return useDrafts.getState().drafts.kitting ?? NEW;
}

beforeEach(() => useDrafts.getState().change("kitting", { ...NEW, rows: ROWS }));

test("the state of an order does not change the goal of the draft", () => {
  const before = draft();
  useDrafts.getState().change("kitting", { job: "kit-1", pending: { key: "k", body: "b" } });
  expect(draft()).not.toBe(before);
  expect(isUntouched(before, draft())).toBe(true);
});

test("a changed row, word or template makes another goal", () => {
  const before = draft();
  useDrafts.getState().change("kitting", ({ rows }) => ({ rows: rows.map((row) => ({ ...row, text: "at_rest" })) }));
  expect(isUntouched(before, draft())).toBe(false);
  useDrafts.getState().change("kitting", { rows: ROWS, template: { name: "kit", parameters: {}, materials: [] } });
  expect(isUntouched(before, draft())).toBe(false);
});
