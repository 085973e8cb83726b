/** Requests as commands for a POSIX shell. */

/** Writes a POST request with JSON, quoted for the shell. */
export function curl(url: string, body: unknown, keysNeeded: boolean): string {
  const key = keysNeeded ? [`-H "Authorization: Bearer $SKIROS_KEY"`] : [];
  const json = ["-H 'Content-Type: application/json'", "-d", quoted(JSON.stringify(body))];
  return ["curl", quoted(url), ...key, ...json].join(" ");
}

/** Returns a text quoted as one word. */
export function quoted(text: string): string {
  return /^[\w@%+=:,./-]+$/.test(text) ? text : `'${text.replaceAll("'", `'\\''`)}'`;
}
