import { Stream } from "../testing/stream";
import { Sharing, type Told } from "./sharing";

const EVENTS = "http://here/api/v1/events";
let sharing: Sharing;

function page() {
  const heard: Told[] = [];
  return { heard, postMessage: (told: Told) => heard.push(told), said: () => heard.map((told) => told.what) };
}

function stream(): Stream {
  const last = Stream.all.at(-1);
  if (last === undefined) throw new Error("nothing was opened");
  return last;
}

beforeEach(() => {
  vi.stubGlobal("EventSource", Stream);
  Stream.all = [];
  sharing = new Sharing();
});
afterEach(() => vi.unstubAllGlobals());

test("however many pages listen, there is one stream, and all hear it", () => {
  const pages = [page(), page(), page()];
  for (const one of pages) sharing.obey(one, { listen: EVENTS });
  stream().onopen?.();
  stream().tell("job", "a-1");
  expect(Stream.all).toHaveLength(1);
  for (const one of pages) expect(one.said()).toEqual(["open", "message"]);
});

test("who comes to an open stream is let in at once", () => {
  const [first, second] = [page(), page()];
  sharing.obey(first, { listen: EVENTS });
  stream().onopen?.();
  sharing.obey(second, { listen: EVENTS });
  expect(second.said()).toEqual(["open"]);
});

test("who wants to go on behind what is past by now is told to read everything anew", () => {
  const [first, second, third] = [page(), page(), page()];
  sharing.obey(first, { listen: EVENTS });
  stream().onopen?.();
  stream().tell("job", "a-8");
  sharing.obey(second, { listen: `${EVENTS}?after=a-5` });
  sharing.obey(third, { listen: `${EVENTS}?after=a-8` });
  expect(second.heard.at(-1)).toMatchObject({
    what: "message",
    kind: "reset",
    id: "a-8",
    address: `${EVENTS}?after=a-5`,
  });
  expect(third.said()).toEqual(["open"]);
});

test("a break is told to all, and whoever comes back first opens the stream behind the last event", () => {
  const [first, second] = [page(), page()];
  for (const one of [first, second]) sharing.obey(one, { listen: EVENTS });
  stream().onopen?.();
  stream().tell("job", "a-3");
  stream().onerror?.();
  for (const one of [first, second]) sharing.obey(one, { listen: `${EVENTS}?after=a-3` });
  expect(Stream.all).toHaveLength(2);
  stream().onopen?.();
  for (const one of [first, second]) expect(one.said()).toEqual(["open", "message", "error", "open"]);
});

test("the stream ends with the last page that leaves", () => {
  const [first, second] = [page(), page()];
  for (const one of [first, second]) sharing.obey(one, { listen: EVENTS });
  sharing.obey(first, { leave: EVENTS, anew: false });
  expect(stream().closed).toBe(false);
  sharing.obey(second, { leave: EVENTS, anew: false });
  expect(stream().closed).toBe(true);
});

test("a stream that may hang is ended for all, and the others are told that it broke", () => {
  const [first, second] = [page(), page()];
  for (const one of [first, second]) sharing.obey(one, { listen: EVENTS });
  stream().onopen?.();
  sharing.obey(first, { leave: EVENTS, anew: true });
  expect(stream().closed).toBe(true);
  expect(second.said()).toEqual(["open", "error"]);
  expect(first.said()).toEqual(["open"]);
});
