import { ancestors, type Classes } from "../world/classes";

interface Term {
  name: string;
  label: string;
  comment: string;
}

/** Returns whether a text in lower case occurs in name, label or comment. */
export function mentions({ name, label, comment }: Term, text: string): boolean {
  return [name, label, comment].some((said) => said.toLowerCase().includes(text));
}

/** Returns the classes that a search shows: matches and all their ancestors; null without a search. */
export function shownClasses(classes: Classes, text: string): ReadonlySet<string> | null {
  if (text === "") return null;
  const found = [...classes.values()].filter((one) => mentions(one, text));
  return new Set(found.flatMap(({ name }) => ancestors(classes, name)));
}
