/** Muted colours, so that selected, questioned and faulty elements stand out. */

import { Color } from "three";
import type { View, ViewElement } from "./view";

export interface Palette {
  background: Color;
  grid: Color;
  gridFar: Color;
  sky: Color;
  ground: Color;
  shade: number;
  selected: Color;
  hovered: Color;
  fits: Color;
  unsure: Color;
  ghost: Color;
  path: Color;
  seen: Color;
  truth: Color;
  /** What cannot be where it is drawn. */
  wrong: Color;
  kinds: Record<ViewElement["kind"], Color>;
}

const PARTS = ["#c8894a", "#4f8fbf", "#7f9f57", "#b06a78", "#8b7cc0", "#b8a23f", "#4fa396", "#b5705a"].map(color);

const LIGHT: Palette = {
  background: color("#e9eef4"),
  grid: color("#b9c4d0"),
  gridFar: color("#d3dbe4"),
  sky: color("#ffffff"),
  ground: color("#a9b0b8"),
  shade: 0.28,
  selected: color("#1c7ed6"),
  hovered: color("#74a9dc"),
  fits: color("#2f9e44"),
  unsure: color("#e8960c"),
  ghost: color("#1c9c8c"),
  path: color("#1971c2"),
  seen: color("#9c36b5"),
  truth: color("#d9480f"),
  wrong: color("#e03131"),
  kinds: {
    part: color("#c8894a"),
    place: color("#b4bfca"),
    furniture: color("#a3adb8"),
    floor: color("#f8fafc"),
    robot: color("#8a939c"),
    device: color("#8a939c"),
    other: color("#a9a2b2"),
  },
};

const DARK: Palette = {
  ...LIGHT,
  background: color("#171b21"),
  grid: color("#38424e"),
  gridFar: color("#262d36"),
  sky: color("#e8f0fa"),
  ground: color("#3a4048"),
  shade: 0.5,
  selected: color("#4dabf7"),
  hovered: color("#7fb4e0"),
  fits: color("#51cf66"),
  unsure: color("#ffc078"),
  ghost: color("#3bc9b4"),
  path: color("#4dabf7"),
  seen: color("#da77f2"),
  truth: color("#ff922b"),
  wrong: color("#ff6b6b"),
  kinds: {
    ...LIGHT.kinds,
    place: color("#6d7987"),
    furniture: color("#5b6672"),
    floor: color("#2b323b"),
    other: color("#6c6678"),
  },
};

export function paletteOf(scheme: "light" | "dark"): Palette {
  return scheme === "dark" ? DARK : LIGHT;
}

/** Gives each class of parts a colour, distinct while colours last. */
export function partColours(view: View): ReadonlyMap<string, Color> {
  const classes = new Set<string>();
  for (const element of view.elements.values()) if (element.kind === "part") classes.add(element.class);
  return new Map([...classes].sort().map((name, i) => [name, PARTS[i % PARTS.length] ?? LIGHT.kinds.part]));
}

export function colourOf(element: ViewElement, palette: Palette, parts: ReadonlyMap<string, Color>): Color {
  if (element.kind === "part") return parts.get(element.class) ?? palette.kinds.part;
  return palette.kinds[element.kind];
}

function color(text: string): Color {
  return new Color(text);
}
