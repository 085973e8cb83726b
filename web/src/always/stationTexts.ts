import type { StationState } from "../live/station";

/** Seconds as a clock: 75 is "1:15", 3675 is "1:01:15". */
export function clock(seconds: number): string {
  const [hours, minutes] = [Math.floor(seconds / 3600), Math.floor(seconds / 60) % 60];
  const ending = String(Math.floor(seconds) % 60).padStart(2, "0");
  return hours > 0 ? `${hours}:${String(minutes).padStart(2, "0")}:${ending}` : `${minutes}:${ending}`;
}

/** A pace with two significant digits: 0.034, 0.5, 12. */
export function rounded(pace: number): number {
  return Number(pace.toPrecision(2));
}

/** The part of the state that shows whether a robot moves. */
interface Robot {
  id: string;
  label: string;
  devices: readonly { id: string }[];
}

/** Names of the moving robots, separated by commas; a string, so that equal results cause no rendering. */
export function movingRobots(state: StationState | null, robots: readonly Robot[]): string {
  if (state === null) return "";
  return robots
    .filter((robot) => robot.devices.some(({ id }) => state.devices[id]?.still === false))
    .map(({ label, id }) => label || id)
    .join(", ");
}

/** The title of the browser window: the state at a glance from other windows. */
export function windowTitle(state: StationState | null, lost: boolean, questions: number, t: TitleWords): string {
  const said = lost ? `⚠ ${t.lost}` : questions > 0 ? `? ${t.asks}` : doing(state, t);
  return said ? `${said} – skiros` : "skiros";
}

export interface TitleWords {
  lost: string;
  asks: string;
  halted: string;
  running: string;
}

function doing(state: StationState | null, t: TitleWords): string {
  if (state?.halted) return `■ ${t.halted}`;
  const running = state?.tasks.find(({ status }) => status === "running" || status === "planning");
  return running ? `● ${running.name} ${t.running}` : "";
}
