import { comeBack, remember } from "./lately";

test("what was looked at comes back while nothing else has begun", () => {
  remember({ detail: "kit-1", task: "kit-2" });
  expect(comeBack(null)).toBe("kit-1");
  expect(comeBack("kit-2")).toBe("kit-1");
});

test("what has begun since comes first", () => {
  remember({ detail: "kit-1", task: "kit-2" });
  expect(comeBack("kit-3")).toBe("");
});

test("who had closed what was chosen gets what is under way", () => {
  remember({ detail: "", task: "kit-2" });
  expect(comeBack(null)).toBe("");
});
