import { ancestors, type Classes } from "../world/classes";

interface Term {
  name: string;
  label: string;
  comment: string;
}

/** Returns whether a text, in small letters, occurs in name, label or comment. */
export function mentions({ name, label, comment }: Term, text: string): boolean {
  return [name, label, comment].some((said) => said.toLowerCase().includes(text));
}

/** Returns the classes that a search shows: those it finds and all above them; null where nothing is searched. */
export function shownClasses(classes: Classes, text: string): ReadonlySet<string> | null {
  if (text === "") return null;
  const found = [...classes.values()].filter((one) => mentions(one, text));
  return new Set(found.flatMap(({ name }) => ancestors(classes, name)));
}
