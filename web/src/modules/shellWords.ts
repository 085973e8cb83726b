/** The same run from a command line. */

import type { Arguments } from "../widgets/ArgumentsForm";

export interface Wanted {
  agent: string;
  module: string;
  values: Arguments;
  repeat: number;
}

/** Returns the command that does the same in a simulation of its own. */
export function cliCommand({ agent, module, values, repeat }: Wanted): string {
  const params = Object.entries(values).map(([key, value]) => `--param ${quoted(`${key}=${asText(value)}`)}`);
  const times = repeat > 1 ? [`--repeat ${repeat}`] : [];
  return ["skiros module run", quoted(module), `--agent ${quoted(agent)}`, ...params, ...times].join(" ");
}

/** Returns the request that asks the same server for the same. */
export function curlCommand({ agent, module, values, repeat }: Wanted, base: string, keysNeeded: boolean): string {
  const url = `${base}/api/v1/modules/${encodeURIComponent(agent)}/${encodeURIComponent(module)}/runs`;
  const key = keysNeeded ? [`-H "Authorization: Bearer $SKIROS_KEY"`] : [];
  const body = JSON.stringify({ arguments: values, repeat });
  return ["curl", quoted(url), ...key, "-H 'Content-Type: application/json'", "-d", quoted(body)].join(" ");
}

function asText(value: unknown): string {
  return typeof value === "object" ? JSON.stringify(value) : String(value);
}

/** Returns a text as one word of a POSIX shell. */
export function quoted(text: string): string {
  return /^[\w@%+=:,./-]+$/.test(text) ? text : `'${text.replaceAll("'", `'\\''`)}'`;
}
