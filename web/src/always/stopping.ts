/** Stops everything: past queues, dialogs and caches, and again and again until somebody has answered. */

import { create } from "zustand";
import { BASE, type Schema } from "../api/client";
import { reconnect } from "../live/connection";

/** How a stop that was asked for here stands. */
export type Verdict = "asking" | "noAnswer" | "notObeyed" | "refused" | "obeyed";

interface Stopping {
  /** Null while nobody has asked for a stop here, or has read what became of it. */
  verdict: Verdict | null;
  /** What the server said besides: why it was refused. */
  text: string;
  forget: () => void;
}

export const useStopping = create<Stopping>((set) => ({
  verdict: null,
  text: "",
  forget: () => {
    round += 1;
    set({ verdict: null, text: "" });
  },
}));

const PATIENCE = 1500; // ms
const AGAIN = 500; // ms
const ROOM_AFTER = 800; // ms without an answer (which may take 500) until the streams give way
const LOOK_AGAIN = 1000; // ms

let round = 0;

/** Asks for a stop until it is answered. A second call while the first one is under way asks at once again. */
export async function stopAll(reason: string): Promise<void> {
  round += 1;
  const mine = round;
  const going = () => mine === round;
  if (useStopping.getState().verdict !== "noAnswer") useStopping.setState({ verdict: "asking", text: "" });
  while (going()) {
    const answered = await ask(reason);
    if (!going()) return;
    useStopping.setState(answered ?? { verdict: "noAnswer", text: "" });
    if (answered?.verdict === "notObeyed") return untilObeyed(going);
    if (answered !== null) return;
    await pause(AGAIN);
  }
}

type Answer = Pick<Stopping, "verdict" | "text">;

/** Asks once; null where nobody answers. */
async function ask(reason: string): Promise<Answer | null> {
  // Several windows of these pages may hold all connections that a browser opens to one server.
  const room = setTimeout(reconnect, ROOM_AFTER);
  try {
    const response = await fetch(`${BASE}/api/v1/stop`, {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify({ reason }),
      keepalive: true,
      priority: "high",
      signal: AbortSignal.timeout(PATIENCE),
    });
    return await meaning(response);
  } catch {
    return null;
  } finally {
    clearTimeout(room);
  }
}

async function meaning(response: Response): Promise<Answer | null> {
  if (response.ok) {
    const { obeyed } = (await response.json()) as Schema<"StopInfo">;
    return { verdict: obeyed ? "obeyed" : "notObeyed", text: "" };
  }
  if (response.status >= 500) return null; // a proxy that reaches nobody, a server that ends
  const problem = (await response.json().catch(() => ({}))) as Partial<Schema<"ProblemDetails">>;
  return { verdict: "refused", text: problem.detail ?? `HTTP ${response.status}` };
}

/** It was heard, and the robots do not come round: looks until they do. */
async function untilObeyed(going: () => boolean): Promise<void> {
  while (going()) {
    await pause(LOOK_AGAIN);
    const obeyed = await isObeyed();
    if (obeyed && going()) return useStopping.setState({ verdict: "obeyed", text: "" });
  }
}

async function isObeyed(): Promise<boolean> {
  try {
    const response = await fetch(`${BASE}/api/v1/stop`, { signal: AbortSignal.timeout(PATIENCE), cache: "no-store" });
    const { halted, obeyed } = (await response.json()) as Schema<"StopInfo">;
    return response.ok && halted && obeyed;
  } catch {
    return false;
  }
}

function pause(milliseconds: number): Promise<void> {
  return new Promise((resolve) => setTimeout(resolve, milliseconds));
}
