import { QueryObserver } from "@tanstack/react-query";
import { answer, api } from "../api/client";
import { queryClient } from "../api/queries";
import i18n from "../i18n";
import { emitEvent, emitReset } from "./events";
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

function isStale(...queryKey: string[]): boolean | undefined {
  return queryClient.getQueryState(queryKey)?.isInvalidated;
}

async function change(data: Record<string, unknown>) {
  emitEvent({ id: "1", number: 1, at: "", time: 0, kind: "world", type: "scene", subject: "", job: "", data });
  await vi.advanceTimersByTimeAsync(100);
}

test("a moved element invalidates the world but not the names", async () => {
  await change({ edits: [{ edit: "placement", element: "starter_1" }] });
  expect(isStale("world", "info")).toBe(true);
  expect(isStale("names", "starter_1")).toBe(false);
});

test("a changed label invalidates the names", async () => {
  await change({ edits: [{ edit: "property", element: "starter_1", property: "rdfs:label" }] });
  expect(isStale("names", "starter_1")).toBe(true);
});

test("a change that is sent in part invalidates the names", async () => {
  await change({ edits: [{ edit: "placement", element: "kit_1" }], all_edits: 200 });
  expect(isStale("names", "starter_1")).toBe(true);
});

/** Runs a query that takes half a second; returns its requests and its displayed values so far, and an unsubscriber. */
function slowly(read: () => number) {
  const asked: number[] = [];
  const shown = new Set<number>();
  const observer = new QueryObserver(queryClient, {
    queryKey: ["world", "slow"],
    queryFn: async () => {
      const now = read();
      asked.push(now);
      await new Promise((resolve) => setTimeout(resolve, 500));
      return now;
    },
  });
  return { asked, shown, end: observer.subscribe(({ data }) => data !== undefined && shown.add(data)) };
}

test("a slow query gets its answers while the world keeps changing, one request at a time", async () => {
  let world = 0;
  const { asked, shown, end } = slowly(() => world);
  for (world = 1; world <= 50; world++) await change({});
  expect(shown.size).toBeGreaterThan(5);
  expect(asked.length).toBeLessThan(shown.size + 3);
  await vi.advanceTimersByTimeAsync(2000);
  expect(queryClient.getQueryData(["world", "slow"])).toBe(world);
  end();
});

test("a change during the first fetch causes another fetch", async () => {
  let world = "before";
  const { end } = slowly(() => (world === "before" ? 0 : 1));
  await vi.advanceTimersByTimeAsync(100);
  world = "after";
  await change({});
  await vi.advanceTimersByTimeAsync(1500);
  expect(queryClient.getQueryData(["world", "slow"])).toBe(1);
  end();
});

test("a reset during the first fetch causes another fetch", async () => {
  let station = "before";
  const { end } = slowly(() => (station === "before" ? 0 : 1));
  await vi.advanceTimersByTimeAsync(100);
  station = "after"; // while no event of it could be received
  emitReset();
  await vi.advanceTimersByTimeAsync(1500);
  expect(queryClient.getQueryData(["world", "slow"])).toBe(1);
  end();
});

test("terms of the ontology are asked for in the language of the pages, and again in another one", async () => {
  const asked: (string | null)[] = [];
  vi.stubGlobal("fetch", async (request: Request) => {
    const language = request.headers.get("Accept-Language");
    asked.push(language);
    return Response.json({ items: [{ name: "sk:pose", label: language === "de" ? "Lage" : "pose" }] });
  });
  const observer = new QueryObserver(queryClient, {
    queryKey: ["ontology", "properties"],
    queryFn: () => answer(api.GET("/api/v1/ontology/properties")),
  });
  const labels: (string | undefined)[] = [];
  const endObserving = observer.subscribe(({ data }) => labels.push(data?.items[0]?.label));
  await vi.advanceTimersByTimeAsync(100);
  expect(asked).toEqual(["en"]);

  await i18n.changeLanguage("de");
  await vi.advanceTimersByTimeAsync(100);
  expect(asked).toEqual(["en", "de"]);
  expect(labels.at(-1)).toBe("Lage");

  end();
  await i18n.changeLanguage("en");
  await vi.advanceTimersByTimeAsync(100);
  expect(asked).toHaveLength(2);
  endObserving();
  vi.unstubAllGlobals();
});
