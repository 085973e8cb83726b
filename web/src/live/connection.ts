/** The two streams of the server: events, and the robots' latest state. Lost ones are shown and opened again. */

import { create } from "zustand";
import { BASE, type Schema } from "../api/client";
import { EVENT_KINDS, tellEvent, tellReset } from "./events";
import { useStation } from "./station";
import { type End, follow } from "./stream";

export type ConnectionStatus = "connecting" | "open" | "lost";

interface Connection {
  status: ConnectionStatus;
  /** When it was lost [ms since 1970]; null while it is not. */
  since: number | null;
  /** Since when the server says nothing of the robots' state, though it answers [ms since 1970]; null while it does. */
  silent: number | null;
}

export const useConnection = create<Connection>(() => ({ status: "connecting", since: null, silent: null }));

const STATE_RATE = 20; // Hz, the most that there is
const FORGOTTEN_AFTER = 60_000; // ms: after a longer gap all is read again, which is less than all the events

let endings: End[] = [];
let lastSeen = ""; // id of the last event
// Something may have been missed of which the server does not know: at first all that came between the first reading
// and the opening of the stream.
let gap = true;
let leftAt = 0;

/** Follows the server until {@link disconnect}; what was open is closed first. */
export function connect(): void {
  closeAll();
  if (leftAt > 0 && Date.now() - leftAt > FORGOTTEN_AFTER) lastSeen = "";
  gap ||= leftAt > 0 && lastSeen === "";
  leftAt = 0;
  endings = [followEvents(), followState()];
}

/** Follows nothing any more: a hidden page must not hold connections, of which a browser has six. */
export function disconnect(): void {
  leftAt = Date.now();
  closeAll();
}

/** Opens the streams again, in case a connection hangs. */
export function reconnect(): void {
  noteLost();
  if (endings.length === 0) return;
  closeAll(true);
  connect();
}

function followEvents(): End {
  return follow({
    address: () => `${BASE}/api/v1/events${lastSeen ? `?after=${encodeURIComponent(lastSeen)}` : ""}`,
    messages: {
      ...Object.fromEntries(EVENT_KINDS.map((kind) => [kind, takeEvent])),
      reset: (message) => {
        lastSeen = message.lastEventId;
        tellReset();
      },
    },
    onOpen: noteOpen,
    onBreak: noteLost,
  });
}

function takeEvent(message: MessageEvent<string>): void {
  lastSeen = message.lastEventId;
  tellEvent(JSON.parse(message.data) as Schema<"EventInfo">);
}

function followState(): End {
  return follow({
    address: () => `${BASE}/api/v1/robots/state/stream?rate=${STATE_RATE}`,
    messages: { state: (message) => useStation.getState().take(JSON.parse(message.data)) },
    onOpen: () => undefined,
    onBreak: () => undefined, // it is silent then, which is looked at
  });
}

function noteOpen(): void {
  useConnection.setState({ status: "open", since: null });
  if (gap) tellReset();
  gap = false;
}

function noteLost(): void {
  gap ||= lastSeen === ""; // else the stream goes on behind that, or says that it cannot
  useConnection.setState(({ since }) => ({ status: "lost", since: since ?? Date.now() }));
}

function closeAll(anew = false): void {
  for (const end of endings) end(anew);
  endings = [];
}
