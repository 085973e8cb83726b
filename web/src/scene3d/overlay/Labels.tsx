import { useMemo } from "react";
import { useTranslation } from "react-i18next";
import { useSelection } from "../../selection/selection";
import { useLayers } from "../layers";
import { useShownView } from "../useShownView";
import type { View, ViewElement } from "../view";
import { labelNodes } from "./labelNodes";
import classes from "./Labels.module.css";

const MOST = 40; // labels, of what is not selected

/** Names over robots, places, and what is selected or pointed at. */
export function Labels() {
  const view = useShownView();
  const shown = useLayers((layers) => layers.shown.labels);
  const selected = useSelection((state) => state.selected);
  const hovered = useSelection((state) => state.hovered);
  const named = useMemo(() => (view !== null && shown ? worthALabel(view) : []), [view, shown]);
  const ids = [...new Set([selected, hovered, ...named])];
  const elements = ids.flatMap((id) => view?.elements.get(id ?? "") ?? []);
  return (
    <div className={classes.labels} aria-hidden>
      {elements.map((element) => (
        <Label key={element.id} element={element} strong={element.id === selected} />
      ))}
    </div>
  );
}

function worthALabel(view: View): string[] {
  const worth = [...view.elements.values()].filter(({ kind, owner, pose, carrier }) => {
    return kind === "robot" || (kind === "place" && owner === null && pose !== null && !carrier);
  });
  return worth.slice(0, MOST).map(({ id }) => id);
}

function Label({ element, strong }: { element: ViewElement; strong: boolean }) {
  const { t } = useTranslation("scene3d");
  const { id, label, pose, place, held_by } = element;
  const unsure = pose === null && place !== null && held_by === null;
  return (
    <div ref={(node) => hold(id, node)} className={classes.label} data-strong={strong || undefined}>
      <span>
        {label === id || label === "" ? id : label}
        {strong && label !== id && <small> {id}</small>}
        {unsure && <small> {t("unsure", { place })}</small>}
      </span>
    </div>
  );
}

function hold(id: string, node: HTMLElement | null): () => void {
  if (node !== null) labelNodes.set(id, node);
  return () => {
    if (labelNodes.get(id) === node) labelNodes.delete(id);
  };
}
