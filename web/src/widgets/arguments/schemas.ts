/** Parameters of modules as form fields: the input for each, and the validation of values. */

import { type Schema as JsonSchema, Validator } from "@cfworker/json-schema";
import type { Schema } from "../../api/client";

export type Parameter = Schema<"ModuleParameter">;

/** Values by parameter key; missing keys are inferred or get their defaults. */
export type Arguments = Record<string, unknown>;

export type { JsonSchema };

export type InputKind =
  | "element"
  | "class"
  | "pose"
  | "boolean"
  | "choice"
  | "number"
  | "integer"
  | "text"
  | "numbers"
  | "vector"
  | "texts"
  | "object"
  | "json";

/** A JSON schema with the definitions of its parameter, which only the outermost schema contains. */
export interface Shape {
  schema: JsonSchema;
  /** Type of the parameter, if more specific than the schema ("class", "pose"); otherwise empty. */
  type: string;
  definitions: Record<string, JsonSchema>;
}

export function shapeOf({ type, json_schema }: Parameter): Shape {
  const schema = json_schema as JsonSchema;
  const items = typeof schema.items === "object" && !Array.isArray(schema.items) ? schema.items : {};
  return within({ schema, type, definitions: { ...items.$defs, ...schema.$defs } }, schema);
}

/** Returns the shape of a part of a value: references resolved, optional types reduced. */
export function within(whole: Shape, part: JsonSchema, type = whole.type): Shape {
  const name = part.$ref?.match(/^#\/\$defs\/(.+)$/)?.[1];
  const target = name === undefined ? undefined : whole.definitions[name];
  if (target !== undefined) return within(whole, { ...target, ...part, $ref: undefined }, type);
  const something = part.anyOf?.filter((one) => one.type !== "null") ?? [];
  const [only] = something;
  if (only !== undefined && something.length === 1) return within(whole, { ...part, anyOf: undefined, ...only }, type);
  return { schema: part, type, definitions: whole.definitions };
}

const LIST_KINDS: Record<string, InputKind> = { number: "numbers", integer: "numbers", string: "texts" };

/** Returns the kind of input; "json" if there is none more specific. */
export function inputKind({ schema, type }: Shape): InputKind {
  if (typeof schema.class === "string") return "element";
  if (schema.enum !== undefined || schema.const !== undefined) return "choice";
  if (schema.type === "array") return listKind(schema, type);
  if (schema.type === "object") return schema.properties === undefined ? "json" : "object";
  if (schema.type === "string") return type === "class" ? "class" : "text";
  return schema.type === "number" || schema.type === "integer" || schema.type === "boolean" ? schema.type : "json";
}

function listKind(schema: JsonSchema, type: string): InputKind {
  if (type === "pose" && count(schema) === 6) return "pose";
  const items = schema.items;
  if (typeof items !== "object" || Array.isArray(items) || items.enum !== undefined) return "json";
  const kind = LIST_KINDS[String(items.type)] ?? "json";
  return kind === "numbers" && count(schema) > 0 ? "vector" : kind;
}

/** Returns the fixed length of a list; 0 if it may vary. */
export function count({ minItems, maxItems }: JsonSchema): number {
  return minItems !== undefined && minItems === maxItems ? minItems : 0;
}

/** Returns the values with one replaced; undefined removes it. */
export function withArgument(values: Arguments, key: string, value: unknown): Arguments {
  const rest = Object.fromEntries(Object.entries(values).filter(([name]) => name !== key));
  return value === undefined ? rest : { ...rest, [key]: value };
}

/** Parameters shown in a form: required ones first, then optional ones; never those for planning. */
export function shownParameters(parameters: readonly Parameter[], hidePlanning = true) {
  const shown = parameters.filter((parameter) => !(hidePlanning && parameter.planning));
  return {
    said: shown.filter(({ kind }) => kind === "online" || kind === "offline"),
    spare: shown.filter(({ kind }) => kind !== "online" && kind !== "offline"),
  };
}

/** A fault of a value. */
export interface Fault {
  /** The keyword of the schema that is violated. */
  keyword: string;
  /** The value of the keyword: the limit, the number of items. */
  limit: unknown;
  /** The validator's message. */
  text: string;
}

/** Returns the fault of a value; null if it is valid, omitted, or can only be checked by the server. */
export function faultOf(schema: JsonSchema, value: unknown): Fault | null {
  if (value === undefined || value === null) return null;
  const { valid, errors } = validated(schema, value);
  const innermost = errors.at(-1);
  if (valid || innermost === undefined) return null;
  const { keyword, error } = innermost;
  return { keyword, limit: schema[keyword], text: error };
}

/** Returns the faults of values, by key. */
export function argumentFaults(parameters: readonly Parameter[], values: Arguments): Record<string, Fault> {
  const faults: Record<string, Fault> = {};
  for (const { key, json_schema } of parameters) {
    const fault = faultOf(json_schema as JsonSchema, values[key]);
    if (fault !== null) faults[key] = fault;
  }
  return faults;
}

function validated(schema: JsonSchema, value: unknown) {
  try {
    return new Validator(schema, "2020-12", false).validate(withoutNaN(value));
  } catch {
    return { valid: true, errors: [] }; // a schema that this validator cannot handle: the server checks anyway
  }
}

/** NaN marks invalid input; the validator accepts it as a number, the server does not. */
function withoutNaN(value: unknown): unknown {
  if (Array.isArray(value)) return value.map(withoutNaN);
  return Number.isNaN(value) ? "NaN" : value;
}
