/** A run as a command line. */

import type { Arguments } from "../widgets/ArgumentsForm";
import { curl, quoted } from "../widgets/shell";

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

/** Returns the HTTP request for the same run on this server. */
export function curlCommand({ agent, module, values, repeat }: Wanted, base: string, keysNeeded: boolean): string {
  const url = `${base}/api/v1/modules/${encodeURIComponent(agent)}/${encodeURIComponent(module)}/runs`;
  return curl(url, { arguments: values, repeat }, keysNeeded);
}

function asText(value: unknown): string {
  return typeof value === "object" ? JSON.stringify(value) : String(value);
}
