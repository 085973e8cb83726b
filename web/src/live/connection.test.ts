import { connect, disconnect, reconnect, useConnection } from "./connection";
import { Stream } from "../testing/stream";
import { onEvent, onReset } from "./events";

const events = () => Stream.all.filter(({ url }) => url.includes("/events")).at(-1) as Stream;
const resets = vi.fn();
let endings: (() => void)[] = [];

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("EventSource", Stream);
  Stream.all = [];
  resets.mockClear();
  endings = [onReset(resets)];
});
afterEach(() => {
  disconnect();
  for (const end of endings) end();
  vi.unstubAllGlobals();
  vi.useRealTimers();
});

test("what was read before the stream was open is read once more, for something may have happened in between", () => {
  connect();
  expect(resets).not.toHaveBeenCalled();
  events().onopen?.();
  expect(resets).toHaveBeenCalledOnce();
});

test("a broken stream is opened again behind the last event that was heard", async () => {
  connect();
  events().onopen?.();
  events().tell("job", "a-5");
  events().onerror?.();
  expect(useConnection.getState().status).toBe("lost");
  await vi.advanceTimersByTimeAsync(1000);
  expect(events().url).toMatch(/after=a-5$/);
  events().onopen?.();
  expect(useConnection.getState()).toMatchObject({ status: "open", since: null });
});

test("a connection stays lost since the first break, however often it is tried", async () => {
  connect();
  events().onopen?.();
  events().onerror?.();
  const { since } = useConnection.getState();
  await vi.advanceTimersByTimeAsync(1000);
  events().onerror?.();
  await vi.advanceTimersByTimeAsync(1000);
  expect(useConnection.getState()).toMatchObject({ status: "lost", since });
});

test("after a short absence the stream goes on where it stood", async () => {
  connect();
  events().onopen?.();
  events().tell("job", "b-7");
  resets.mockClear();
  disconnect();
  await vi.advanceTimersByTimeAsync(10_000);
  connect();
  events().onopen?.();
  expect(events().url).toMatch(/after=b-7$/);
  expect(resets).not.toHaveBeenCalled();
});

test("after a long absence everything is read anew, and not every event of it", async () => {
  connect();
  events().onopen?.();
  events().tell("job", "c-7");
  resets.mockClear();
  disconnect();
  await vi.advanceTimersByTimeAsync(3_600_000);
  connect();
  events().onopen?.();
  expect(events().url).not.toMatch(/after/);
  expect(resets).toHaveBeenCalledOnce();
});

test("a reset of the server is passed on, and what comes behind it is heard", () => {
  const heard = vi.fn();
  endings.push(onEvent(heard));
  connect();
  events().onopen?.();
  resets.mockClear();
  events().tell("reset", "d-1");
  expect(resets).toHaveBeenCalledOnce();
  events().tell("job", "d-2");
  expect(heard).toHaveBeenCalledWith({ id: "d-2", kind: "job" });
});

test("a reconnection closes what hung", () => {
  connect();
  const hanging = events();
  reconnect();
  expect(hanging.closed).toBe(true);
  expect(events()).not.toBe(hanging);
});

test("who follows nothing opens nothing", () => {
  disconnect();
  reconnect();
  expect(Stream.all).toHaveLength(0);
});
