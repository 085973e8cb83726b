import { argumentFaults, inputKind, shapeOf } from "../../widgets/arguments/schemas";
import { extended, parameterOf, paths, type Signal, type Traces } from "./traces";

function at(time: number, value: number | boolean | number[] | null) {
  return { time, cycle: 200 * time, signals: { one: { value, reason: value === null ? "off" : "" } } };
}

function tracesOf(...readings: ReturnType<typeof at>[]): Traces {
  return readings.reduce<Traces | undefined>(extended, undefined) as Traces;
}

test("numbers and vectors are kept for the last seconds, booleans are not", () => {
  expect(tracesOf(at(0, 1), at(5, 2), at(21, [3, 4])).points["one"]).toEqual([
    { time: 5, values: [2] },
    { time: 21, values: [3, 4] },
  ]);
  expect(tracesOf(at(0, true)).points["one"]).toEqual([]);
});

test("a signal without a value leaves a gap and shows the reason", () => {
  const traces = tracesOf(at(0, 1), at(1, null));
  expect(traces.points["one"]).toHaveLength(1);
  expect(traces.signals["one"]?.reason).toBe("off");
});

test("the same cycle fetched twice makes one point, and a new run starts a new line", () => {
  expect(tracesOf(at(4, 1), at(4, 1)).points["one"]).toHaveLength(1);
  expect(tracesOf(at(4, 1), at(0.5, 7)).points["one"]).toEqual([{ time: 0.5, values: [7] }]);
});

test("each component of a vector is a line, all on one scale", () => {
  const { points } = tracesOf(at(0, [0, 1]), at(20, [2, 1]));
  expect(paths(points["one"] ?? [], 100, 20)).toEqual(["M0.0 20.0L100.0 0.0", "M0.0 10.0L100.0 10.0"]);
});

test("a constant value is a line in the middle", () => {
  expect(paths(tracesOf(at(10, 5), at(20, 5)).points["one"] ?? [], 100, 20)).toEqual(["M50.0 10.0L100.0 10.0"]);
});

test("the form of an input fits its shape", () => {
  const signal: Signal = {
    name: "v",
    unit: "m/s",
    dimension: "",
    frame: "",
    help: "",
    length: null,
    source: "v",
    input: true,
  };
  const kinds = [parameterOf(signal, 0.5), parameterOf(signal, true), parameterOf({ ...signal, length: 3 }, [0, 0, 0])];
  expect(kinds.map((one) => inputKind(shapeOf(one)))).toEqual(["number", "boolean", "vector"]);
  expect(Object.keys(argumentFaults(kinds.slice(2), { v: [1, 2] }))).toEqual(["v"]);
});
