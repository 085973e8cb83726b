import { act, renderHook } from "@testing-library/react";
import { comesBackTo, leave, useOpenAsLeft } from "./useTab";

function opened() {
  const { result } = renderHook(() => useOpenAsLeft());
  return (tab: Parameters<typeof result.current>[0]) => act(() => result.current(tab));
}

beforeEach(() => {
  window.location.hash = "#/goal";
});

test("a tab reopens with its last content", () => {
  leave("world", "kit_1");
  opened()("world");
  expect(window.location.hash).toBe("#/world/kit_1");
});

test("a tab can define the content it opens with, and whether its button leaves the current content", () => {
  leave("task", "kit-1");
  comesBackTo("task", (isOpen) => (isOpen ? "" : "kit-2"));
  opened()("task");
  expect(window.location.hash).toBe("#/task/kit-2");
  opened()("task");
  expect(window.location.hash).toBe("#/task");
});
