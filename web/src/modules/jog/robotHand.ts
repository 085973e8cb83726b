/** The hand on the real server. */

import { answer, api } from "../../api/client";
import { onEvent } from "../../live/events";
import { problemText } from "../../widgets/problems";
import type { Arguments } from "../../widgets/ArgumentsForm";
import type { Run } from "../queries";
import { makeHand, type Step } from "./hand";

const LOOK_AGAIN = 400; // ms, where no event comes

async function over(id: string): Promise<Run> {
  for (;;) {
    const news = nextNews();
    const run = await answer(api.GET("/api/v1/module-runs/{id}", { params: { path: { id } } }));
    if (["succeeded", "failed", "stopped"].includes(run.status)) return run;
    await news;
  }
}

/** Resolves at the next event of a module, or after a while: its last event comes a moment before its end. */
function nextNews(): Promise<void> {
  return new Promise((resolve) => {
    const done = () => {
      clearTimeout(timer);
      end();
      resolve();
    };
    const timer = setTimeout(done, LOOK_AGAIN);
    const end = onEvent((event) => {
      if (event.kind === "module" && event.type !== "running") setTimeout(done, 10);
    });
  });
}

function stop(id: string): Promise<unknown> {
  return answer(api.POST("/api/v1/module-runs/{id}/{command}", { params: { path: { id, command: "stop" } } }));
}

export const hand = makeHand({ over, stop }, problemText);

/** Moves a device with one of the modules that its kind names for jogging. */
export function jog(device: string, module: string, values: Arguments = {}): Step {
  const [path, body] = [{ id: device }, { module, arguments: values }];
  return () => answer(api.POST("/api/v1/devices/{id}/jog", { params: { path }, body }));
}

/** Learns from a device with one of the modules that its kind names for teaching. */
export function teach(device: string, module: string, values: Arguments): Step {
  const [path, body] = [{ id: device }, { module, arguments: values }];
  return () => answer(api.POST("/api/v1/devices/{id}/teach", { params: { path }, body }));
}
