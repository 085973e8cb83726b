/** Looks whether the server is there while nothing is heard of it: a broken cable says nothing by itself. */

import { BASE } from "../api/client";
import { reconnect, useConnection } from "./connection";
import { useStation } from "./station";

const LOOK = 1000; // ms
const SILENT_AFTER = 3000; // ms without a state, of which there are twenty in a second
const PATIENCE = 2500; // ms

/**
 * Watches until the function that it returns is called.
 *
 * @param onBack - Called when a server that was lost answers again: the session has to be read again.
 */
export function watch(onBack: () => void): () => void {
  const begun = performance.now();
  let asking = false;
  const look = async () => {
    const silence = performance.now() - Math.max(begun, useStation.getState().at);
    const { status, silent } = useConnection.getState();
    if (silence < SILENT_AFTER && status !== "lost") {
      if (silent !== null) useConnection.setState({ silent: null });
    } else if (!asking) {
      asking = true;
      await ask(Date.now() - silence, onBack);
      asking = false;
    }
  };
  const timer = setInterval(() => void look(), LOOK);
  return () => clearInterval(timer);
}

async function ask(since: number, onBack: () => void): Promise<void> {
  const answered = await answers();
  const { status } = useConnection.getState();
  if (answered && status === "open") useConnection.setState({ silent: since });
  if (answered && status === "lost") onBack();
  if (!answered && status === "open") reconnect();
}

/** Returns whether the server answers at all; also when it says that its robots do not. */
async function answers(): Promise<boolean> {
  try {
    const { status } = await fetch(`${BASE}/healthz`, { signal: AbortSignal.timeout(PATIENCE), cache: "no-store" });
    return status < 500 || status === 503; // a proxy without a server behind it says 502 or 504
  } catch {
    return false;
  }
}
