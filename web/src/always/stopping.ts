/** Stops everything: past queues, dialogs and caches, and again and again until the server has answered. */

import { create } from "zustand";
import { BASE, type Schema } from "../api/client";
import { reconnect } from "../live/connection";

/** How a stop that was asked for here stands. */
export type Verdict = "asking" | "noAnswer" | "notObeyed" | "refused" | "signedOut" | "unsent" | "obeyed";

interface Stopping {
  /** Null while no stop was asked for here, or its result has been read. */
  verdict: Verdict | null;
  /** What the server said besides: why it was refused. */
  text: string;
  /** Ends it: a stop without an answer is withdrawn, one with an answer stands. */
  forget: () => void;
  /** A user signed in again: a stop that could not be sent before is asked about, since it may no longer be wanted. */
  signedIn: () => void;
}

export const useStopping = create<Stopping>((set) => ({
  verdict: null,
  text: "",
  forget: () => {
    round += 1;
    set({ verdict: null, text: "" });
  },
  signedIn: () => set(({ verdict }) => ({ verdict: verdict === "signedOut" ? "unsent" : verdict })),
}));

const NOTICE_AFTER = 1500; // ms without an answer until that is said
const AGAIN = 2000; // ms between two tries; each goes on while the next begins: any answer is one
const PATIENCE = 8000; // ms for one try
const LOOK = 50; // ms
const LOOK_AGAIN = 1000; // ms

let round = 0;

/** Asks for a stop until it is answered. A second call while the first one is under way asks at once again. */
export async function stopAll(reason: string): Promise<void> {
  round += 1;
  const mine = round;
  const open = () => mine === round && !isAnswer(useStopping.getState().verdict);
  useStopping.setState(({ verdict }) => ({ verdict: verdict === "noAnswer" ? verdict : "asking", text: "" }));
  const room = setTimeout(reconnect, NOTICE_AFTER / 2); // several windows may hold all that a browser connects
  const notice = setTimeout(() => open() && giveNotice(), NOTICE_AFTER);
  while (open()) {
    void ask(reason).then((answer) => {
      if (open()) settle(answer, () => mine === round);
    });
    await whileOpen(open, AGAIN);
  }
  clearTimeout(room);
  clearTimeout(notice);
}

type Answer = Pick<Stopping, "verdict" | "text">;

function isAnswer(verdict: Verdict | null): boolean {
  return verdict !== "asking" && verdict !== "noAnswer";
}

function giveNotice(): void {
  useStopping.setState({ verdict: "noAnswer", text: "" });
}

function settle(answer: Answer | null, mine: () => boolean): void {
  if (answer === null) return giveNotice();
  useStopping.setState(answer);
  if (answer.verdict === "notObeyed") void untilObeyed(mine);
}

/** Asks once; null without an answer. */
async function ask(reason: string): Promise<Answer | null> {
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
  }
}

async function meaning(response: Response): Promise<Answer | null> {
  if (response.ok) {
    const { obeyed } = (await response.json()) as Schema<"StopInfo">;
    return { verdict: obeyed ? "obeyed" : "notObeyed", text: "" };
  }
  if (response.status === 401) return { verdict: "signedOut", text: "" };
  if (response.status >= 500) return null; // a proxy without a server, a server that ends
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

/** Waits, but no longer than something is open. */
async function whileOpen(open: () => boolean, milliseconds: number): Promise<void> {
  const until = Date.now() + milliseconds;
  while (open() && Date.now() < until) await pause(LOOK);
}

function pause(milliseconds: number): Promise<void> {
  return new Promise((resolve) => setTimeout(resolve, milliseconds));
}
