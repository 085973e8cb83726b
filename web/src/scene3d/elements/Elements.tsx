import { useFrame } from "@react-three/fiber";
import { useEffect, useMemo } from "react";
import { Color } from "three";
import { useStation } from "../../live/station";
import { type Pick, useSelection } from "../../selection/selection";
import { useLayers } from "../layers";
import { colourOf, type Palette, partColours } from "../palette";
import { useModels } from "../robots/models";
import { wake } from "../ticker";
import { useShownView } from "../useShownView";
import type { ViewElement } from "../view";
import { crowd } from "./crowd";

const DIM = 0.72; // towards the background, of elements that cannot be picked
const LIT = 0.5; // of elements that can be picked
const TINT = 0.55; // of the selected element

/** All elements except robots. */
export function Elements({ palette }: { palette: Palette }) {
  const view = useShownView();
  const carriers = useStation(({ state }) => Object.keys(state?.platforms ?? {}).join(" "));
  const models = useModels();
  const rooms = useLayers(({ shown }) => shown.rooms);
  const selected = useSelection((state) => state.selected);
  const hovered = useSelection((state) => state.hovered);
  const pick = useSelection((state) => state.pick);
  const parts = useMemo(() => (view === null ? new Map<string, Color>() : partColours(view)), [view]);
  useEffect(() => {
    const hidden = ({ id, hollow }: ViewElement) => (hollow && !rooms) || id in models;
    if (view !== null) crowd.show(view, hidden, new Set(carriers.split(" ")));
  }, [view, rooms, carriers, models]);
  useEffect(() => {
    const paint = painter(palette, { selected, hovered, pick });
    crowd.paint((element, sure) => paint(element, colourOf(element, palette, parts), sure));
    wake();
  }, [view, rooms, carriers, models, palette, parts, selected, hovered, pick]);
  useEffect(() => () => crowd.dispose(), []);
  useFrame(() => crowd.follow(), -1);
  return <primitive object={crowd.group} />;
}

interface Attention {
  selected: string | null;
  hovered: string | null;
  pick: Pick | null;
}

function painter(palette: Palette, { selected, hovered, pick }: Attention) {
  const colour = new Color();
  return ({ id }: ViewElement, own: Color, sure: boolean): Color => {
    colour.copy(own);
    if (!sure) colour.lerp(palette.unsure, 0.25);
    if (pick?.fits(id) === true) colour.lerp(palette.fits, LIT);
    else if (pick !== null) colour.lerp(palette.background, DIM);
    if (id === selected) colour.lerp(palette.selected, TINT);
    else if (id === hovered) colour.lerp(palette.hovered, TINT);
    return colour;
  };
}
