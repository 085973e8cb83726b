import { Stream } from "../testing/stream";
import { SharedStreams, type StreamMessage } from "./sharedStreams";

const EVENTS = "http://here/api/v1/events";
let streams: SharedStreams;

function page() {
  const received: StreamMessage[] = [];
  return {
    received,
    postMessage: (message: StreamMessage) => received.push(message),
    types: () => received.map(({ type }) => type),
  };
}

function stream(): Stream {
  const last = Stream.all.at(-1);
  if (last === undefined) throw new Error("no stream was opened");
  return last;
}

beforeEach(() => {
  vi.stubGlobal("EventSource", Stream);
  Stream.all = [];
  streams = new SharedStreams();
});
afterEach(() => vi.unstubAllGlobals());

test("all pages share one stream and receive its messages", () => {
  const pages = [page(), page(), page()];
  for (const one of pages) streams.handle(one, { subscribe: EVENTS });
  stream().onopen?.();
  stream().send("job", "a-1");
  expect(Stream.all).toHaveLength(1);
  for (const one of pages) expect(one.types()).toEqual(["open", "message"]);
});

test("a page that subscribes to an open stream receives `open` at once", () => {
  const [first, second] = [page(), page()];
  streams.handle(first, { subscribe: EVENTS });
  stream().onopen?.();
  streams.handle(second, { subscribe: EVENTS });
  expect(second.types()).toEqual(["open"]);
});

test("a page that has missed events of an open stream receives a reset", () => {
  const [first, second, third] = [page(), page(), page()];
  streams.handle(first, { subscribe: EVENTS });
  stream().onopen?.();
  stream().send("job", "a-8");
  streams.handle(second, { subscribe: `${EVENTS}?after=a-5` });
  streams.handle(third, { subscribe: `${EVENTS}?after=a-8` });
  expect(second.received.at(-1)).toMatchObject({
    type: "message",
    kind: "reset",
    id: "a-8",
    address: `${EVENTS}?after=a-5`,
  });
  expect(third.types()).toEqual(["open"]);
});

test("all pages receive an error, and the first one that returns reopens the stream after the last event", () => {
  const [first, second] = [page(), page()];
  for (const one of [first, second]) streams.handle(one, { subscribe: EVENTS });
  stream().onopen?.();
  stream().send("job", "a-3");
  stream().onerror?.();
  for (const one of [first, second]) streams.handle(one, { subscribe: `${EVENTS}?after=a-3` });
  expect(Stream.all).toHaveLength(2);
  stream().onopen?.();
  for (const one of [first, second]) expect(one.types()).toEqual(["open", "message", "error", "open"]);
});

test("the stream closes when the last page unsubscribes", () => {
  const [first, second] = [page(), page()];
  for (const one of [first, second]) streams.handle(one, { subscribe: EVENTS });
  streams.handle(first, { unsubscribe: EVENTS, restart: false });
  expect(stream().closed).toBe(false);
  streams.handle(second, { unsubscribe: EVENTS, restart: false });
  expect(stream().closed).toBe(true);
});

test("a restarted stream closes for all pages, and the others receive an error", () => {
  const [first, second] = [page(), page()];
  for (const one of [first, second]) streams.handle(one, { subscribe: EVENTS });
  stream().onopen?.();
  streams.handle(first, { unsubscribe: EVENTS, restart: true });
  expect(stream().closed).toBe(true);
  expect(second.types()).toEqual(["open", "error"]);
  expect(first.types()).toEqual(["open"]);
});
