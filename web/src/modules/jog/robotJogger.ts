/** Jogs through the server. */

import { answer, api } from "../../api/client";
import { onEvent } from "../../live/events";
import { problemText } from "../../widgets/problems";
import type { Arguments } from "../../widgets/ArgumentsForm";
import type { Run } from "../queries";
import { makeJogger, type Step } from "./jogger";

const POLL = 400; // ms, used if no event arrives

async function ended(id: string): Promise<Run> {
  for (;;) {
    const change = nextChange();
    const run = await answer(api.GET("/api/v1/module-runs/{id}", { params: { path: { id } } }));
    if (["succeeded", "failed", "stopped"].includes(run.status)) return run;
    await change;
  }
}

/** Resolves shortly after the next event of a module (its last event precedes its end), or after {@link POLL}. */
function nextChange(): Promise<void> {
  return new Promise((resolve) => {
    const done = () => {
      clearTimeout(timer);
      unsubscribe();
      resolve();
    };
    const timer = setTimeout(done, POLL);
    const unsubscribe = onEvent((event) => {
      if (event.kind === "module" && event.type !== "running") setTimeout(done, 10);
    });
  });
}

function stop(id: string): Promise<unknown> {
  return answer(api.POST("/api/v1/module-runs/{id}/{command}", { params: { path: { id, command: "stop" } } }));
}

export const jogger = makeJogger({ ended, stop }, problemText);

/** Moves a device with one of the jog modules of its kind. */
export function jog(device: string, module: string, values: Arguments = {}): Step {
  const [path, body] = [{ id: device }, { module, arguments: values }];
  return () => answer(api.POST("/api/v1/devices/{id}/jog", { params: { path }, body }));
}

/** Teaches with a device, with one of the teach modules of its kind. */
export function teach(device: string, module: string, values: Arguments): Step {
  const [path, body] = [{ id: device }, { module, arguments: values }];
  return () => answer(api.POST("/api/v1/devices/{id}/teach", { params: { path }, body }));
}
