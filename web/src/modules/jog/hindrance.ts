/** The reasons for which a robot cannot be jogged. */

import type { StationState } from "../../live/station";
import type { RobotInfo as Robot } from "../../api/cell";

export type Hindrance =
  | { why: "unknown" }
  | { why: "halted"; text: string }
  | { why: "atWork" | "paused"; modules: string[] }
  | { why: "task"; tasks: string[] };

/**
 * Returns the reason, from the latest state; null if there is none.
 *
 * @param own - Whether the running module is a jog step started here.
 * @param alone - Whether it is the only robot: then every running task is its task.
 */
export function hindranceOf(state: StationState | null, robot: Robot, own: boolean, alone: boolean): Hindrance | null {
  if (state === null) return { why: "unknown" };
  if (state.halted) return { why: "halted", text: state.halted };
  const modules = state.modules.filter(({ agent, status }) => robot.agents.includes(agent) && status !== "ended");
  if (modules.length > 0 && !own) {
    const why = modules.every(({ status }) => status === "paused") ? "paused" : "atWork";
    return { why, modules: modules.map(({ agent, module }) => `${module} (${agent})`) };
  }
  const tasks = state.tasks.filter(({ status }) => status === "planning" || status === "running");
  if (alone && tasks.length > 0) return { why: "task", tasks: tasks.map(({ name }) => name) };
  return null;
}
