/** Values of properties: their kinds, and their notation for people. */

import { numbersOf } from "../scene3d/pose";
import { nameNow, spoken } from "../widgets/names";

export type ValueKind = "number" | "integer" | "boolean" | "pose" | "vector" | "json" | "class" | "text";

const KINDS: Readonly<Record<string, ValueKind>> = {
  "xsd:decimal": "number",
  "xsd:double": "number",
  "xsd:float": "number",
  "xsd:integer": "integer",
  "xsd:int": "integer",
  "xsd:nonNegativeInteger": "integer",
  "xsd:boolean": "boolean",
  "sk:poseLiteral": "pose",
  "sk:vectorLiteral": "vector",
  "rdf:JSON": "json",
  "sk:className": "class",
};

export function kindOf(datatype: string): ValueKind {
  return KINDS[datatype] ?? "text";
}

type Three = [number, number, number];
type Four = [number, number, number, number];

/** A pose; with a frame only if it can be chosen. */
export interface PoseValue {
  position: Three;
  orientation: Four;
  frame?: string | null;
}

export function isPose(value: unknown): value is PoseValue {
  return typeof value === "object" && value !== null && "position" in value && "orientation" in value;
}

/** Formats a value in one line. */
export function written(value: unknown, words: { yes: string; no: string; none: string }): string {
  if (value === null || value === undefined) return words.none;
  if (typeof value === "boolean") return value ? words.yes : words.no;
  if (typeof value === "number") return String(round(value, 6));
  if (Array.isArray(value))
    return value.map((one) => (typeof one === "number" ? round(one, 4) : String(one))).join(" ");
  if (isPose(value)) return poseText(value);
  if (typeof value === "object") return objectText(value);
  return String(value);
}

export function poseText(pose: PoseValue): string {
  const { x, y, z, roll, pitch, yaw } = numbersOf(pose);
  const turn = roll || pitch || yaw ? `; ${roll}, ${pitch}, ${yaw}°` : "";
  return `${x}, ${y}, ${z} m${turn}${pose.frame ? ` @ ${nameNow(pose.frame)}` : ""}`;
}

function objectText(value: object): string {
  if ("relation" in value && "place" in value)
    return `${spoken(String(value.relation))} ${nameNow(String(value.place))}`;
  return JSON.stringify(value);
}

/** Parses numbers separated by blanks or commas; other input stays text, which the server refuses with a reason. */
export function vectorOf(text: string): number[] | string {
  const numbers = text
    .trim()
    .split(/[\s,;]+/)
    .map(Number);
  return text.trim() !== "" && numbers.every(Number.isFinite) ? numbers : text;
}

function round(value: number, digits: number): number {
  return Number(value.toFixed(digits)) + 0; // no -0
}
