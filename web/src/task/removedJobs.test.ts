import { renderHook } from "@testing-library/react";
import type { Schema } from "../api/client";
import { type EventInfo, emitEvent } from "../live/events";
import { useReplay } from "../scene3d/replay";
import { useIsGone } from "./removedJobs";

function tell(type: string, subject: string): void {
  emitEvent({ kind: "job", type, subject, data: {} } as unknown as EventInfo);
}
function isGone(job: string): boolean {
  const { result, unmount } = renderHook(() => useIsGone(job));
  unmount();
  return result.current;
}

test("a job removed by another person is gone, with its replay, until its id is used again", () => {
  useReplay.setState({ replay: { job: "kit-1" } as Schema<"Replay">, speed: 2 });
  tell("Removed", "kit-2");
  expect([isGone("kit-1"), isGone("kit-2"), useReplay.getState().replay?.job]).toEqual([false, true, "kit-1"]);
  tell("Removed", "kit-1");
  expect([isGone("kit-1"), useReplay.getState().replay, useReplay.getState().speed]).toEqual([true, null, 0]);
  tell("AllowedToStart", "kit-1");
  expect(isGone("kit-1")).toBe(false);
});
