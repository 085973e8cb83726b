/** Requests as lines for a POSIX shell. */

/** Writes a POST with JSON; whatever characters are in it, the shell reads them as they are. */
export function curl(url: string, body: unknown, keysNeeded: boolean): string {
  const key = keysNeeded ? [`-H "Authorization: Bearer $SKIROS_KEY"`] : [];
  const json = ["-H 'Content-Type: application/json'", "-d", quoted(JSON.stringify(body))];
  return ["curl", quoted(url), ...key, ...json].join(" ");
}

/** Returns a text as one word. */
export function quoted(text: string): string {
  return /^[\w@%+=:,./-]+$/.test(text) ? text : `'${text.replaceAll("'", `'\\''`)}'`;
}
