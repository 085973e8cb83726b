import { useTab } from "../app/useTab";

export const VIEWS = ["scene", "ontology", "query", "scenes"] as const;
export type View = (typeof VIEWS)[number];

/** Which part of the World tab the address names (`#/world/ontology/sk:Robot`), what of it, and how to open one. */
export function useView(): [view: View, about: string, open: (view: View, about?: string) => void] {
  const [, openTab, detail] = useTab();
  const [name = "", ...rest] = detail.split("/");
  const view = VIEWS.find((known) => known === name) ?? "scene";
  const open = (next: View, about = "") => openTab("world", about ? `${next}/${about}` : next);
  return [view, rest.join("/"), open];
}
