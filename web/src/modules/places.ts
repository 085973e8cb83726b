/** The address behind `#/modules/`: "try/arm_1/pick", "jog/robot_1", "runs/3f2a-1", "plugins". */

export const VIEWS = ["try", "jog", "devices", "runs", "plugins"] as const;
export type View = (typeof VIEWS)[number];

export interface Place {
  view: View;
  rest: string[];
}

export function placeOf(detail: string): Place {
  const [name = "", ...rest] = detail.split("/").filter(Boolean);
  const view = VIEWS.find((known) => known === name);
  return view === undefined ? { view: "try", rest: [] } : { view, rest };
}

export function detailOf(view: View, ...rest: string[]): string {
  return [view, ...rest].join("/");
}
