/** Example worlds for tests. */

import type { Block, ViewElement, WorldView } from "./view";

export function box(x: number, y: number, z: number): Block {
  return { kind: "box", size: [x, y, z], pose: { position: [0, 0, z / 2], orientation: [0, 0, 0, 1] } };
}

export function element(id: string, rest: Partial<ViewElement> = {}): ViewElement {
  const nowhere = { pose: null, carrier: null, place: null, owner: null, held_by: null, in_hand: null };
  return {
    id,
    class: "test:Thing",
    label: id,
    ...nowhere,
    shape: null,
    hollow: false,
    kind: "part",
    version: 1,
    ...rest,
  };
}

export function at(x: number, y: number, z: number): ViewElement["pose"] {
  return { position: [x, y, z], orientation: [0, 0, 0, 1] };
}

export function world(elements: ViewElement[], rest: Partial<WorldView> = {}): WorldView {
  return { version: 1, elements, shapes: {}, gone: [], ...rest };
}
