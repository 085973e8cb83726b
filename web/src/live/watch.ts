/** Probes the server when no messages arrive: a broken cable causes no error in the browser. */

import { BASE } from "../api/client";
import { reconnect, useConnection } from "./connection";
import { useStation } from "./station";

const INTERVAL = 1000; // ms
const SILENT_AFTER = 3000; // ms without a state; the server sends 20 a second
const TIMEOUT = 2500; // ms

/**
 * Watches the connection until the returned function is called.
 *
 * @param onBack - Called when a lost server answers again: the session must be fetched again.
 */
export function watch(onBack: () => void): () => void {
  const started = performance.now();
  let probing = false;
  const check = async () => {
    const silence = performance.now() - Math.max(started, useStation.getState().at);
    const { status, silent } = useConnection.getState();
    if (silence < SILENT_AFTER && status !== "lost") {
      if (silent !== null) useConnection.setState({ silent: null });
    } else if (!probing) {
      probing = true;
      await probe(Date.now() - silence, onBack);
      probing = false;
    }
  };
  const timer = setInterval(() => void check(), INTERVAL);
  return () => clearInterval(timer);
}

async function probe(since: number, onBack: () => void): Promise<void> {
  const answered = await answers();
  const { status } = useConnection.getState();
  if (answered && status === "open") useConnection.setState({ silent: since });
  if (answered && status === "lost") onBack();
  if (!answered && status === "open") reconnect();
}

/** Whether the server answers, even if its robots are not ready. */
async function answers(): Promise<boolean> {
  try {
    const { status } = await fetch(`${BASE}/healthz`, { signal: AbortSignal.timeout(TIMEOUT), cache: "no-store" });
    return status < 500 || status === 503; // a proxy without a server behind it answers 502 or 504
  } catch {
    return false;
  }
}
