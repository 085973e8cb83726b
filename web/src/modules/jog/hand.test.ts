import type { Run } from "../queries";
import { makeHand, type Step, told } from "./hand";

/** A robot that does a step whenever the test says so. */
function robot() {
  const done: string[] = [];
  const stops: string[] = [];
  const waiting: ((run: Run) => void)[] = [];
  let count = 0;
  const run = (id: string, status: Run["status"], text: string) =>
    ({ id, status, rounds: [{ success: true, code: 1, text, start: 0, end: 0 }] }) as unknown as Run;
  const step =
    (name: string): Step =>
    () => {
      count += 1;
      done.push(name);
      return Promise.resolve(run(String(count), "running", ""));
    };
  const end = async (status: Run["status"] = "succeeded", text = "moved") => {
    await settled();
    waiting.shift()?.(run(String(count), status, text));
    await settled();
  };
  const hand = makeHand(
    {
      over: () => new Promise((resolve) => waiting.push(resolve)),
      stop: (id) => Promise.resolve(stops.push(id)),
    },
    String,
  );
  return { done, stops, step, end, hand };
}

const settled = () => new Promise((resolve) => setTimeout(resolve));

test("a click is one whole step, which is not stopped", async () => {
  const { done, stops, step, end, hand } = robot();
  hand.hold(step("a"));
  hand.release();
  await end();
  expect(done).toEqual(["a"]);
  expect(stops).toEqual([]);
  expect(hand.useHand.getState()).toEqual({ moving: false, said: { good: true, text: "moved" } });
});

test("while it is held, step follows step; released, the one under way is stopped at once", async () => {
  const { done, stops, step, end, hand } = robot();
  hand.hold(step("a"));
  await end();
  await end();
  await settled();
  expect(done).toEqual(["a", "a", "a"]);
  hand.release();
  expect(stops).toEqual(["3"]);
  await end("stopped", "stopped");
  expect(done).toHaveLength(3);
  expect(hand.useHand.getState().moving).toBe(false);
});

test("a refused step ends it, and its words are said", async () => {
  const { done, step, end, hand } = robot();
  hand.hold(step("a"));
  await end("failed", "arm_1 would touch pallet_a");
  expect(done).toHaveLength(1);
  expect(hand.useHand.getState()).toEqual({
    moving: false,
    said: { good: false, text: "arm_1 would touch pallet_a" },
  });
});

test("a second wish comes when the first has ended, and a third takes its place", async () => {
  const { done, step, end, hand } = robot();
  hand.once(step("a"));
  await settled();
  hand.once(step("b"));
  hand.once(step("c"));
  await end();
  await end();
  expect(done).toEqual(["a", "c"]);
});

test("stop ends steps that are still to come, even before the first has been answered", async () => {
  const { done, stops, step, end, hand } = robot();
  const left = [step("a"), step("b")];
  hand.all(() => left.shift() ?? null);
  void hand.stop();
  await end("stopped", "stopped");
  expect(stops).toEqual(["1"]);
  expect(done).toEqual(["a"]);
});

test("whoever presses again right after a stop is heard", async () => {
  const { done, step, end, hand } = robot();
  hand.hold(step("a"));
  await end();
  await settled();
  void hand.stop();
  hand.once(step("b"));
  await end("stopped", "stopped");
  await end();
  expect(done).toEqual(["a", "a", "b"]);
  expect(hand.useHand.getState().said).toEqual({ good: true, text: "moved" });
});

test("what the server refuses at once is said, and the next step may come", async () => {
  const { done, step, end, hand } = robot();
  hand.once(() => Promise.reject(new Error("robot_1 is at work")));
  await settled();
  expect(hand.useHand.getState().said?.text).toContain("robot_1 is at work");
  hand.once(step("a"));
  await end();
  expect(done).toEqual(["a"]);
});

test("a step that went well is told in its own words, one that did not in those of the module", async () => {
  const { step, end, hand } = robot();
  hand.once(told(step("a"), "joint 1 turned by 2°"));
  await end("succeeded", "turned by 0.035 rad");
  expect(hand.useHand.getState().said).toEqual({ good: true, text: "joint 1 turned by 2°" });
  hand.once(told(step("a"), "joint 1 turned by 2°"));
  await end("failed", "something is in the way");
  expect(hand.useHand.getState().said).toEqual({ good: false, text: "something is in the way" });
});
