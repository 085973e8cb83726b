/** The two streams of the server: events, and the robots' latest state; shows when they are lost, and reconnects. */

import { create } from "zustand";
import { BASE, type Schema } from "../api/client";
import { EVENT_KINDS, emitEvent, emitReset } from "./events";
import { useStation } from "./station";
import { type Close, follow } from "./stream";

export type ConnectionStatus = "connecting" | "open" | "lost";

interface Connection {
  status: ConnectionStatus;
  /** Time of the loss [ms since 1970]; null while connected. */
  since: number | null;
  /** Time of the last state of the robots, if the server answers but sends no states [ms since 1970]; else null. */
  silent: number | null;
}

export const useConnection = create<Connection>(() => ({ status: "connecting", since: null, silent: null }));

const STATE_RATE = 20; // Hz, the maximum of the API
const REPLAY_LIMIT = 60_000; // ms: after a longer gap, fetching all data again is cheaper

let closings: Close[] = [];
let lastSeen = ""; // id of the last event received
// Whether events may have been missed without the server noticing: at first those between the first requests and the
// opening of the stream.
let gap = true;
let leftAt = 0;

/** Follows the server until {@link disconnect}; closes open streams first. */
export function connect(): void {
  closeAll();
  if (leftAt > 0 && Date.now() - leftAt > REPLAY_LIMIT) lastSeen = "";
  gap ||= leftAt > 0 && lastSeen === "";
  leftAt = 0;
  closings = [followEvents(), followState()];
}

/** Closes the streams: a hidden page must not hold connections, of which a browser has six. */
export function disconnect(): void {
  leftAt = Date.now();
  closeAll();
}

/** Reopens the streams, in case a connection hangs. */
export function reconnect(): void {
  noteLost();
  if (closings.length === 0) return;
  closeAll(true);
  connect();
}

function followEvents(): Close {
  return follow({
    address: () => `${BASE}/api/v1/events${lastSeen ? `?after=${encodeURIComponent(lastSeen)}` : ""}`,
    handlers: {
      ...Object.fromEntries(EVENT_KINDS.map((kind) => [kind, receiveEvent])),
      reset: (message) => {
        lastSeen = message.lastEventId;
        emitReset();
      },
    },
    onOpen: noteOpen,
    onLost: noteLost,
  });
}

function receiveEvent(message: MessageEvent<string>): void {
  lastSeen = message.lastEventId;
  emitEvent(JSON.parse(message.data) as Schema<"EventInfo">);
}

function followState(): Close {
  return follow({
    address: () => `${BASE}/api/v1/robots/state/stream?rate=${STATE_RATE}`,
    handlers: { state: (message) => useStation.getState().take(JSON.parse(message.data)) },
    onOpen: () => undefined,
    onLost: () => undefined, // watch.ts detects missing states
  });
}

function noteOpen(): void {
  useConnection.setState({ status: "open", since: null });
  if (gap) emitReset();
  gap = false;
}

function noteLost(): void {
  gap ||= lastSeen === ""; // otherwise the stream continues after that event or sends a reset
  useConnection.setState(({ since }) => ({ status: "lost", since: since ?? Date.now() }));
}

function closeAll(restart = false): void {
  for (const close of closings) close(restart);
  closings = [];
}
