/** Orders a job exactly once, despite double clicks and lost answers. */

import { answer, api, ApiProblem, type Schema } from "../api/client";
import { keys } from "../api/keys";
import { useSingleMutation } from "../api/mutations";
import { queryClient } from "../api/queries";
import { notifyProblem } from "../widgets/problems";
import { type Options, useDraft } from "./draft";
import type { GoalOrder } from "./goals";

export type JobOrder = Schema<"JobOrder">;

const TRIES = 3;

export function jobOrder(order: GoalOrder, options: Options): JobOrder {
  return { ...order, ...options, expires: false };
}

/** Returns the key of an order: the same one until its arrival is confirmed. */
export function keyFor(body: string, pending: { key: string; body: string } | null): string {
  return pending?.body === body ? pending.key : newKey();
}

/** A unique key; randomUUID exists only on pages served over HTTPS or from this machine. */
function newKey(): string {
  return Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");
}

export function useOrder() {
  const { draft, change } = useDraft();
  return useSingleMutation({
    mutationFn: (order: JobOrder) => {
      const body = JSON.stringify(order);
      const key = keyFor(body, draft.pending);
      change({ pending: { key, body } });
      return send(order, key);
    },
    onSuccess: (job) => {
      change({ pending: null, job: job.id, preview: null });
      void queryClient.invalidateQueries({ queryKey: keys.jobs() });
    },
    onError: (error) => {
      if (error instanceof ApiProblem && error.status < 500) change({ pending: null });
      notifyProblem(error);
    },
  });
}

/** Repeats an order without an answer: the key makes that harmless. */
async function send(order: JobOrder, key: string): Promise<Schema<"AcceptedJob">> {
  for (let left = TRIES - 1; ; left--) {
    try {
      const params = { header: { "idempotency-key": key } };
      return await answer(api.POST("/api/v1/jobs", { body: order, params }));
    } catch (error) {
      if (left === 0 || !(error instanceof TypeError)) throw error;
    }
  }
}
