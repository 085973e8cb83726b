import { afterEach, describe, expect, it, vi } from "vitest";
import { type EventInfo, emitEvent, emitReset } from "../live/events";
import { at, box, element, world } from "./testing";
import { followView, madeOld, merged, useLiveView, viewFrom } from "./view";

function changed(data: object): EventInfo {
  const rest = { id: "1-1", number: 1, at: "2026-11-20T09:30:00Z", time: 0, type: "scene", subject: "", job: "" };
  return { ...rest, kind: "world", data: data as EventInfo["data"] };
}

describe("elements to fetch after an event", () => {
  it("are those named by its edits, without duplicates", () => {
    const edits = [
      { edit: "placement", element: "a" },
      { edit: "property", element: "a" },
      { edit: "relation", subject: "b", object: "c" },
      { edit: "goals" },
    ];
    expect(madeOld(changed({ edits }))).toEqual(["a", "b", "c"]);
  });

  it("are all if it was sent in part", () => {
    expect(madeOld(changed({ edits: [], all_edits: 4000 }))).toBe("all");
  });

  it("are all when a station opens, and none when a job continues", () => {
    expect(madeOld({ ...changed({}), kind: "system", type: "opened" })).toBe("all");
    expect(madeOld({ ...changed({}), kind: "job" })).toEqual([]);
  });
});

describe("merging fetched elements into a view", () => {
  const before = viewFrom(world([element("a"), element("b")], { shapes: { one: [box(1, 1, 1)] } }));
  const after = merged(before, world([element("b", { place: "c" })], { version: 2, gone: ["a"], shapes: { two: [] } }));

  it("adds changes, drops removed elements, and keeps all shapes", () => {
    expect([...after.elements.keys()]).toEqual(["b"]);
    expect(after.elements.get("b")?.place).toBe("c");
    expect(Object.keys(after.shapes)).toEqual(["one", "two"]);
  });

  it("does not modify the previous view", () => {
    expect([...before.elements.keys()]).toEqual(["a", "b"]);
  });
});

describe("following the world", () => {
  let end: () => void = () => undefined;
  afterEach(() => {
    end();
    useLiveView.setState({ view: null, problem: null });
  });

  function serve(...answers: object[]): string[] {
    const asked: string[] = [];
    vi.spyOn(globalThis, "fetch").mockImplementation((request) => {
      asked.push(new URL((request as Request).url).search);
      return Promise.resolve(Response.json(answers[Math.min(asked.length, answers.length) - 1]));
    });
    end = followView();
    return asked;
  }

  it("fetches everything once, then what events name", async () => {
    const asked = serve(world([element("a", { pose: at(0, 0, 0) })]), world([element("a", { pose: at(1, 0, 0) })]));
    await vi.waitFor(() => expect(useLiveView.getState().view).not.toBeNull());
    emitEvent(changed({ edits: [{ edit: "property", element: "a" }] }));
    await vi.waitFor(() => expect(useLiveView.getState().view?.elements.get("a")?.pose?.position[0]).toBe(1));
    expect(asked).toEqual(["", "?element=a"]);
  });

  it("fetches everything again when events may have been missed", async () => {
    const asked = serve(world([element("a")]), world([element("b")]));
    await vi.waitFor(() => expect(useLiveView.getState().view).not.toBeNull());
    emitReset();
    await vi.waitFor(() => expect(useLiveView.getState().view?.elements.has("b")).toBe(true));
    expect(asked).toEqual(["", ""]);
    expect(useLiveView.getState().view?.elements.has("a")).toBe(false);
  });
});
