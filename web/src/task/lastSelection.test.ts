import { selectionToRestore, remember } from "./lastSelection";

test("the last selection is restored if nothing has started since", () => {
  remember({ detail: "kit-1", task: "kit-2" });
  expect(selectionToRestore(null)).toBe("kit-1");
  expect(selectionToRestore("kit-2")).toBe("kit-1");
});

test("a task that has started since takes precedence", () => {
  remember({ detail: "kit-1", task: "kit-2" });
  expect(selectionToRestore("kit-3")).toBe("");
});

test("after closing the selection the running task is shown", () => {
  remember({ detail: "", task: "kit-2" });
  expect(selectionToRestore(null)).toBe("");
});
