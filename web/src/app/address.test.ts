import { addressOf, readAddress } from "./address";

test("an address names a tab and its content", () => {
  expect(readAddress("/task/kit-17")).toEqual({ tab: "task", detail: "kit-17" });
});

test.each(["kit/17", "100 %", "ä#?&", "<img src=x>"])("any content can be named: %s", (detail) => {
  expect(readAddress(addressOf("world", detail))).toEqual({ tab: "world", detail });
});

test.each([
  ["", "goal", ""],
  ["/nowhere", "goal", ""],
  ["/task/100%", "task", "100%"],
  ["/task/%E4%A", "task", "%E4%A"],
])("a mistyped address throws nothing: %s", (path, tab, detail) => {
  expect(readAddress(path)).toEqual({ tab, detail });
});
