/** Faults of fields, translated if possible. */

import i18n from "../i18n";
import { said } from "../i18n/sentences";

/** A fault in the server's format. */
export interface FieldFault extends Faulty {
  field: string;
}

interface Faulty {
  message: string;
  /** The kind of fault: the server's name, or the violated keyword of a JSON schema. */
  kind?: string;
  /** The violated limit, if any. */
  limit?: number;
}

const OURS = {
  bool_type: "bool",
  bool_parsing: "bool",
  int_type: "whole",
  int_parsing: "whole",
  int_from_float: "whole",
  float_type: "number",
  float_parsing: "number",
  finite_number: "number",
  string_type: "text",
  list_type: "list",
  tuple_type: "list",
  missing: "missing",
  greater_than_equal: "lowest",
  greater_than: "moreThan",
  less_than_equal: "highest",
  less_than: "lessThan",
  string_too_short: "shortest",
  string_too_long: "longest",
  too_short: "fewest",
  too_long: "most",
  minimum: "lowest",
  exclusiveMinimum: "moreThan",
  maximum: "highest",
  exclusiveMaximum: "lessThan",
  minLength: "shortest",
  maxLength: "longest",
  minItems: "fewest",
  maxItems: "most",
} as const;

/** The text of a fault, to be shown after the name of the field. */
export function faultText({ message, kind, limit }: Faulty): string {
  if (kind === undefined || !isOurs(kind)) return said(message);
  return i18n.t(`fault.${OURS[kind]}`, { limit, count: limit });
}

function isOurs(kind: string): kind is keyof typeof OURS {
  return kind in OURS;
}
