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

test("a value that is made in each rendering is one change only where a part of it differs", () => {
  const { result } = renderHook(() => {
    const [text, set] = useState("a");
    useHistoryKeys(useHistoryOf({ text }, (past) => set(past.text)));
    return { text, set };
  });
  act(() => result.current.set("b"));
  act(() => pressed("undo"));
  expect(result.current.text).toBe("a");
  act(() => pressed("redo"));
  expect(result.current.text).toBe("b");
});

test("a value stays as it is where what has to succeed before fails", async () => {
  const refused = vi.fn(() => Promise.reject(new Error("changed by somebody else")));
  const { result } = renderHook(() => {
    const [text, set] = useState("a");
    useHistoryKeys(useHistoryOf({ text }, (past) => set(past.text), refused));
    return { text, set };
  });
  act(() => result.current.set("b"));
  await act(async () => pressed("undo"));
  expect(refused).toHaveBeenCalledWith({ text: "a" });
  expect(result.current.text).toBe("b");
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
