import { useTab } from "../app/useTab";

export const VIEWS = ["scene", "ontology", "query", "scenes"] as const;
export type View = (typeof VIEWS)[number];

/** The view of the World tab and its subject in the address (`#/world/ontology/sk:Robot`), and how to open one. */
export function useView(): [view: View, about: string, open: (view: View, about?: string) => void] {
  const [, openTab, detail] = useTab();
  const [name = "", ...rest] = detail.split("/");
  const view = VIEWS.find((known) => known === name) ?? "scene";
  const open = (next: View, about = "") => openTab("world", about ? `${next}/${about}` : next);
  return [view, rest.join("/"), open];
}
