/** The recent values of signals, for their plots. */

import type { Schema } from "../../api/client";
import type { Parameter } from "../../widgets/arguments/schemas";

export type Signal = Schema<"CellSignal">;
export type Reading = Schema<"SignalReading">;

export interface Point {
  /** Run time [s]. */
  time: number;
  /** One number, or the components of a vector. */
  values: readonly number[];
}

export interface Traces {
  time: number;
  cycle: number;
  signals: Readonly<Record<string, Reading>>;
  points: Readonly<Record<string, readonly Point[]>>;
}

const SPAN = 20; // s of run time
const MOST = 120; // points

/** Appends new values to the traces; they restart when the clock of the run does. */
export function extended(before: Traces | undefined, { time, cycle, signals }: Schema<"SignalReadings">): Traces {
  const known = before !== undefined && before.time <= time ? before.points : {};
  const points = Object.entries(signals).map(([name, { value }]) => {
    const kept = (known[name] ?? []).filter((point) => point.time >= time - SPAN && point.time < time);
    const values = typeof value === "number" ? [value] : Array.isArray(value) ? value : null;
    return [name, values === null ? kept : [...kept, { time, values }].slice(-MOST)] as const;
  });
  return { time, cycle, signals, points: Object.fromEntries(points) };
}

/** Returns an SVG path for each component of a signal, on a common scale, as wide as the time span. */
export function paths(points: readonly Point[], width: number, height: number): string[] {
  const end = points.at(-1)?.time ?? 0;
  const all = points.flatMap(({ values }) => values);
  const [low, high] = [Math.min(...all), Math.max(...all)];
  const x = (time: number) => (width * (1 - (end - time) / SPAN)).toFixed(1);
  const y = (value: number) => (high > low ? height * (1 - (value - low) / (high - low)) : height / 2).toFixed(1);
  const count = points.at(-1)?.values.length ?? 0;
  return Array.from({ length: count }, (_, index) =>
    points.map(({ time, values }, at) => `${at === 0 ? "M" : "L"}${x(time)} ${y(values[index] ?? 0)}`).join(""),
  );
}

/** Returns an input signal as a parameter, for the form that sets it. */
export function parameterOf({ name, unit, help, length }: Signal, value: Reading["value"] | undefined): Parameter {
  const number = { type: "number" };
  const vector = { type: "array", items: number, minItems: length ?? 0, maxItems: length ?? 0 };
  const single = typeof value === "boolean" ? { type: "boolean" } : number;
  const json_schema = length === null ? single : vector;
  return { key: name, type: "", kind: "online", help, unit, required: true, planning: false, json_schema };
}
