import { connect, disconnect, reconnect, useConnection } from "./connection";
import { Stream } from "../testing/stream";
import { onEvent, onReset } from "./events";

const events = () => Stream.all.filter(({ url }) => url.includes("/events")).at(-1) as Stream;
const resets = vi.fn();
let closings: (() => void)[] = [];

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("EventSource", Stream);
  Stream.all = [];
  resets.mockClear();
  closings = [onReset(resets)];
});
afterEach(() => {
  disconnect();
  for (const close of closings) close();
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

test("data fetched before the stream opened is fetched again, since events may have been missed", () => {
  connect();
  expect(resets).not.toHaveBeenCalled();
  events().onopen?.();
  expect(resets).toHaveBeenCalledOnce();
});

test("a lost stream reopens after the last event received", async () => {
  connect();
  events().onopen?.();
  events().send("job", "a-5");
  events().onerror?.();
  expect(useConnection.getState().status).toBe("lost");
  await vi.advanceTimersByTimeAsync(1000);
  expect(events().url).toMatch(/after=a-5$/);
  events().onopen?.();
  expect(useConnection.getState()).toMatchObject({ status: "open", since: null });
});

test("failed retries do not change the time at which the connection was lost", async () => {
  connect();
  events().onopen?.();
  events().onerror?.();
  const { since } = useConnection.getState();
  await vi.advanceTimersByTimeAsync(1000);
  events().onerror?.();
  await vi.advanceTimersByTimeAsync(1000);
  expect(useConnection.getState()).toMatchObject({ status: "lost", since });
});

test("after a short absence the stream continues where it stopped", async () => {
  connect();
  events().onopen?.();
  events().send("job", "b-7");
  resets.mockClear();
  disconnect();
  await vi.advanceTimersByTimeAsync(10_000);
  connect();
  events().onopen?.();
  expect(events().url).toMatch(/after=b-7$/);
  expect(resets).not.toHaveBeenCalled();
});

test("after a long absence all data is fetched again instead of replaying the missed events", async () => {
  connect();
  events().onopen?.();
  events().send("job", "c-7");
  resets.mockClear();
  disconnect();
  await vi.advanceTimersByTimeAsync(3_600_000);
  connect();
  events().onopen?.();
  expect(events().url).not.toMatch(/after/);
  expect(resets).toHaveBeenCalledOnce();
});

test("a reset by the server is passed on, and so are the events after it", () => {
  const heard = vi.fn();
  closings.push(onEvent(heard));
  connect();
  events().onopen?.();
  resets.mockClear();
  events().send("reset", "d-1");
  expect(resets).toHaveBeenCalledOnce();
  events().send("job", "d-2");
  expect(heard).toHaveBeenCalledWith({ id: "d-2", kind: "job" });
});

test("reconnecting closes a connection that hangs", () => {
  connect();
  const hanging = events();
  reconnect();
  expect(hanging.closed).toBe(true);
  expect(events()).not.toBe(hanging);
});

test("reconnecting does nothing while disconnected", () => {
  disconnect();
  reconnect();
  expect(Stream.all).toHaveLength(0);
});
