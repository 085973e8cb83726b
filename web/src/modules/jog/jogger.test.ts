import type { Run } from "../queries";
import { makeJogger, type Step, withDoneText } from "./jogger";

/** A robot whose steps end when the test calls `end`. */
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
  const jogger = makeJogger(
    {
      ended: () => new Promise((resolve) => waiting.push(resolve)),
      stop: (id) => Promise.resolve(stops.push(id)),
    },
    String,
  );
  return { done, stops, step, end, jogger };
}

const settled = () => new Promise((resolve) => setTimeout(resolve));

test("a click is one whole step, which is not stopped", async () => {
  const { done, stops, step, end, jogger } = robot();
  jogger.hold(step("a"));
  jogger.release();
  await end();
  expect(done).toEqual(["a"]);
  expect(stops).toEqual([]);
  expect(jogger.useState.getState()).toEqual({ moving: false, result: { succeeded: true, text: "moved" } });
});

test("steps repeat while the button is held; releasing it stops the running step at once", async () => {
  const { done, stops, step, end, jogger } = robot();
  jogger.hold(step("a"));
  await end();
  await end();
  await settled();
  expect(done).toEqual(["a", "a", "a"]);
  jogger.release();
  expect(stops).toEqual(["3"]);
  await end("stopped", "stopped");
  expect(done).toHaveLength(3);
  expect(jogger.useState.getState().moving).toBe(false);
});

test("a failed step ends the motion, and its text is shown", async () => {
  const { done, step, end, jogger } = robot();
  jogger.hold(step("a"));
  await end("failed", "arm_1 would touch pallet_a");
  expect(done).toHaveLength(1);
  expect(jogger.useState.getState()).toEqual({
    moving: false,
    result: { succeeded: false, text: "arm_1 would touch pallet_a" },
  });
});

test("a second request waits for the running step, and a third one replaces it", async () => {
  const { done, step, end, jogger } = robot();
  jogger.once(step("a"));
  await settled();
  jogger.once(step("b"));
  jogger.once(step("c"));
  await end();
  await end();
  expect(done).toEqual(["a", "c"]);
});

test("stop discards the steps to come, even before the server has answered the first one", async () => {
  const { done, stops, step, end, jogger } = robot();
  const left = [step("a"), step("b")];
  jogger.all(() => left.shift() ?? null);
  void jogger.stop();
  await end("stopped", "stopped");
  expect(stops).toEqual(["1"]);
  expect(done).toEqual(["a"]);
});

test("a step requested right after a stop is carried out", async () => {
  const { done, step, end, jogger } = robot();
  jogger.hold(step("a"));
  await end();
  await settled();
  void jogger.stop();
  jogger.once(step("b"));
  await end("stopped", "stopped");
  await end();
  expect(done).toEqual(["a", "a", "b"]);
  expect(jogger.useState.getState().result).toEqual({ succeeded: true, text: "moved" });
});

test("a refusal by the server is shown, and the next step can start", async () => {
  const { done, step, end, jogger } = robot();
  jogger.once(() => Promise.reject(new Error("robot_1 is at work")));
  await settled();
  expect(jogger.useState.getState().result?.text).toContain("robot_1 is at work");
  jogger.once(step("a"));
  await end();
  expect(done).toEqual(["a"]);
});

test("a successful step shows its own text, a failed one that of the module", async () => {
  const { step, end, jogger } = robot();
  jogger.once(withDoneText(step("a"), "joint 1 turned by 2°"));
  await end("succeeded", "turned by 0.035 rad");
  expect(jogger.useState.getState().result).toEqual({ succeeded: true, text: "joint 1 turned by 2°" });
  jogger.once(withDoneText(step("a"), "joint 1 turned by 2°"));
  await end("failed", "something is in the way");
  expect(jogger.useState.getState().result).toEqual({ succeeded: false, text: "something is in the way" });
});
