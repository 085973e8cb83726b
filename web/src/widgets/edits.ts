/** Changes of the world in words. */

import i18n from "../i18n";
import { written } from "../world/values";
import { nameNow, spoken } from "./names";

/** An edit of a change, as the API describes it. */
export type Edit = Readonly<Record<string, unknown>>;

export interface EditText {
  /** Id of the changed element; empty for none. */
  element: string;
  text: string;
}

/** Whether an edit is about an element. */
export function isAbout(edit: Edit, element: string): boolean {
  return [edit.element, edit.subject, edit.object].includes(element);
}

export function editText({ edit, old, new: next, ...about }: Edit): EditText {
  const element = String(about.element ?? about.subject ?? "");
  if (edit === "element") return { element, text: i18n.t(next == null ? "edit.removed" : "edit.added") };
  if (edit === "relation")
    return {
      element,
      text: `${next === true ? "+" : "−"} ${spoken(String(about.relation))} ${nameNow(String(about.object))}`,
    };
  const what = edit === "property" ? `${spoken(String(about.property))}: ` : "";
  return { element, text: `${what}${valueText(old)} → ${valueText(next)}` };
}

function valueText(value: unknown): string {
  if (typeof value === "object" && value !== null && "value" in value) return valueText(value.value);
  return written(value, { yes: i18n.t("world:value.yes"), no: i18n.t("world:value.no"), none: "–" });
}
