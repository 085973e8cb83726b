import { queryClient } from "../api/queries";
import { tellEvent } from "./events";
import { keepFresh } from "./freshness";

let end = () => {};

beforeEach(() => {
  vi.useFakeTimers();
  queryClient.setQueryData(["names", "starter_1"], "starter");
  queryClient.setQueryData(["world", "info"], {});
  end = keepFresh();
});
afterEach(() => {
  end();
  queryClient.clear();
  vi.useRealTimers();
});

function isOld(...queryKey: string[]): boolean | undefined {
  return queryClient.getQueryState(queryKey)?.isInvalidated;
}

async function change(data: Record<string, unknown>) {
  tellEvent({ id: "1", number: 1, at: "", time: 0, kind: "world", type: "scene", subject: "", job: "", data });
  await vi.advanceTimersByTimeAsync(100);
}

test("a change that moves something makes the world old, and no name", async () => {
  await change({ edits: [{ edit: "placement", element: "starter_1" }] });
  expect(isOld("world", "info")).toBe(true);
  expect(isOld("names", "starter_1")).toBe(false);
});

test("another label makes names old", async () => {
  await change({ edits: [{ edit: "property", element: "starter_1", property: "rdfs:label" }] });
  expect(isOld("names", "starter_1")).toBe(true);
});

test("a change of which only a part is told may have renamed anything", async () => {
  await change({ edits: [{ edit: "placement", element: "kit_1" }], all_edits: 200 });
  expect(isOld("names", "starter_1")).toBe(true);
});
