/** A request as a line for a shell. */

/** Writes a POST with JSON; whatever characters are in it, the shell reads them as they are. */
export function curl(url: string, body: unknown, headers: Readonly<Record<string, string>> = {}): string {
  const all = { "Content-Type": "application/json", ...headers };
  const parts = Object.entries(all).map(([name, value]) => `-H ${quoted(`${name}: ${value}`)}`);
  return ["curl -X POST", quoted(url), ...parts, "-d", quoted(JSON.stringify(body))].join(" ");
}

function quoted(text: string): string {
  return `'${text.replaceAll("'", String.raw`'\''`)}'`;
}
