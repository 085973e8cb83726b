import { act, renderHook } from "@testing-library/react";
import { useState } from "react";
import { pressed, useHistoryKeys, useHistoryOf } from "./history";

/** A value with its history, as a part of the page has it. */
function useEdited() {
  const [value, set] = useState("a");
  useHistoryKeys(useHistoryOf(value, set));
  return { value, set };
}

test("changes are taken back and done again one by one, until another change", () => {
  const { result } = renderHook(useEdited);
  const press = (command: "undo" | "redo") => act(() => pressed(command));
  act(() => result.current.set("b"));
  act(() => result.current.set("c"));
  press("undo");
  expect(result.current.value).toBe("b");
  press("undo");
  press("undo");
  expect(result.current.value).toBe("a");
  press("redo");
  expect(result.current.value).toBe("b");
  act(() => result.current.set("d"));
  press("redo");
  expect(result.current.value).toBe("d");
  press("undo");
  expect(result.current.value).toBe("b");
});

test("the keys act on what is shown", () => {
  const first = renderHook(useEdited);
  const second = renderHook(useEdited);
  act(() => first.result.current.set("b"));
  act(() => second.result.current.set("c"));
  second.unmount();
  act(() => pressed("undo"));
  expect(first.result.current.value).toBe("a");
});
