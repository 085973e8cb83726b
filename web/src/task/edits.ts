/** Short descriptions of changes of the world, with the names of the ontology. */

export interface EditText {
  /** Id of the changed element; empty for none. */
  element: string;
  text: string;
}

export function editText(edit: Record<string, unknown>): EditText {
  const { old, new: next } = edit;
  const element = String(edit.element ?? edit.subject ?? "");
  if (edit.edit === "placement") return { element, text: `${place(old)} → ${place(next)}` };
  if (edit.edit === "property") return { element, text: `${edit.property}: ${plain(old)} → ${plain(next)}` };
  if (edit.edit === "relation")
    return { element, text: `${next === true ? "+" : "−"} ${edit.relation} ${edit.object}` };
  if (edit.edit === "element") return { element, text: next == null ? "−" : "+" };
  return { element, text: `${plain(old)} → ${plain(next)}` };
}

function place(value: unknown): string {
  if (typeof value !== "object" || value === null || !("place" in value)) return "–";
  const relation = "relation" in value ? String(value.relation).replace(/^.*:/, "") : "";
  return `${relation} ${String(value.place)}`.trim();
}

function plain(value: unknown): string {
  if (value == null) return "–";
  if (typeof value !== "object") return String(value);
  if ("value" in value) return plain(value.value);
  return JSON.stringify(value, (_, one: unknown) => (typeof one === "number" ? Number(one.toPrecision(4)) : one));
}
