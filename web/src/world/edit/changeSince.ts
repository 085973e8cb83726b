interface Versioned {
  version: number;
}

/** The number of the change that made an element what it is now; null where it still is as it was seen. */
export function changeSince(seen: Versioned, now: Versioned): number | null {
  return now.version === seen.version ? null : now.version; // the version of an element is its last change's number
}
