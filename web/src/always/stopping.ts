/** Stops everything: bypasses queues, dialogs and caches, and repeats the request until the server has answered. */

import { create } from "zustand";
import { BASE, type Schema } from "../api/client";
import { reconnect } from "../live/connection";
import { learn } from "../i18n/sentences";

/** The state of a stop requested here. */
export type Verdict = "asking" | "noAnswer" | "notObeyed" | "refused" | "signedOut" | "unsent" | "obeyed";

interface Stopping {
  /** Null if no stop was requested here, or its result was acknowledged. */
  verdict: Verdict | null;
  /** The server's text, for example the reason of a refusal. */
  text: string;
  /** Ends it: withdraws an unanswered stop, acknowledges an answered one. */
  forget: () => void;
  /** After a new login, asks whether to send a stop that could not be sent: it may no longer be wanted. */
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

const NOTICE_AFTER = 1500; // ms without an answer before it is reported
const AGAIN = 2000; // ms between two attempts; they overlap, and any answer counts
const PATIENCE = 8000; // ms for one attempt
const LOOK = 50; // ms
const LOOK_AGAIN = 1000; // ms

let round = 0;

/** Requests a stop until it is answered. A second call meanwhile sends another request at once. */
export async function stopAll(reason: string): Promise<void> {
  round += 1;
  const mine = round;
  const open = () => mine === round && !isAnswer(useStopping.getState().verdict);
  useStopping.setState(({ verdict }) => ({ verdict: verdict === "noAnswer" ? verdict : "asking", text: "" }));
  const room = setTimeout(reconnect, NOTICE_AFTER / 2); // several windows may use all connections of the browser
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

/** Sends one request; null without an answer. */
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
  if (response.status >= 500) return null; // a proxy without a server, or a server that shuts down
  const problem = (await response.json().catch(() => ({}))) as Partial<Schema<"ProblemDetails">>;
  learn(problem);
  return { verdict: "refused", text: problem.detail ?? `HTTP ${response.status}` };
}

/** The stop was received but the control cycle does not respond: polls until it does. */
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

/** Waits for a time, or until the state is no longer open. */
async function whileOpen(open: () => boolean, milliseconds: number): Promise<void> {
  const until = Date.now() + milliseconds;
  while (open() && Date.now() < until) await pause(LOOK);
}

function pause(milliseconds: number): Promise<void> {
  return new Promise((resolve) => setTimeout(resolve, milliseconds));
}
