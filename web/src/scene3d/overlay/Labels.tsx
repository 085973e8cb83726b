import { useEffect, useMemo } from "react";
import { useTranslation } from "react-i18next";
import type { Vector3 } from "three";
import { usePretends } from "../../api/cell";
import { useSelection } from "../../selection/selection";
import { useLayers } from "../layers";
import { pointOf } from "../pointing";
import { wake } from "../ticker";
import { useShownView } from "../useShownView";
import type { View, ViewElement } from "../view";
import { type FloatingLabel, useFloating } from "./floating";
import { hold } from "./labelNodes";
import classes from "./Labels.module.css";
import { isolated } from "../../i18n/isolated";
import { nameNow } from "../../widgets/names";

const MOST = 40; // labels of elements that are not selected

/** Labels of robots, places, and the selected or hovered element. */
export function Labels() {
  const view = useShownView();
  const shown = useLayers((layers) => layers.shown.labels);
  const selected = useSelection((state) => state.selected);
  const hovered = useSelection((state) => state.hovered);
  const named = useMemo(() => (view !== null && shown ? worthALabel(view) : []), [view, shown]);
  const ids = [...new Set([selected, hovered, ...named])];
  const elements = ids.flatMap((id) => view?.elements.get(id ?? "") ?? []);
  const seen = useFloating((state) => state.labels);
  useEffect(() => wake()); // new labels need positions
  return (
    <div className={classes.labels} aria-hidden>
      {elements.map((element) => (
        <Label key={element.id} element={element} strong={element.id === selected} />
      ))}
      {shown && seen.map((label) => <SeenLabel key={label.key} label={label} />)}
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
  const { id, kind, label, pose, place, held_by } = element;
  const at = kind === "place" && !strong ? "middle" : "top"; // objects on a place must stay visible
  const unsure = pose === null && place !== null && held_by === null;
  const pretends = usePretends() && kind === "robot";
  return (
    <div
      ref={(node) => hold(node, (into) => pointOf(id, at, into))}
      className={classes.label}
      data-strong={strong || undefined}
    >
      <span>
        {isolated(label || id)}
        {strong && label !== id && <small> {id}</small>}
        {pretends && <small> {t("pretended")}</small>}
        {unsure && <small> {t("unsure", { place: nameNow(place) })}</small>}
      </span>
    </div>
  );
}

function SeenLabel({ label }: { label: FloatingLabel }) {
  const { t } = useTranslation("scene3d");
  const where = (into: Vector3) => into.copy(label.point) === into;
  return (
    <div ref={(node) => hold(node, where)} className={classes.label} data-seen>
      <span>{label.type === null ? t("seenUnknown") : label.type.replace(/^.*:/, "")}</span>
    </div>
  );
}
