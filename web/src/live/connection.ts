/** The two streams of the server: events, and the robots' latest state. Lost ones are shown and opened again. */

import { create } from "zustand";
import { BASE, type Schema } from "../api/client";
import { tellEvent, tellReset } from "./events";
import { useStation } from "./station";

export type ConnectionStatus = "connecting" | "open" | "lost";

interface Connection {
  status: ConnectionStatus;
}

export const useConnection = create<Connection>(() => ({ status: "connecting" }));

const KINDS = ["world", "module", "task", "job", "alarm", "system"];
const STATE_RATE = 20; // Hz, the most that there is

let streams: EventSource[] = [];
let missed = false;

/** Follows the server until {@link disconnect}; what was open is closed first. */
export function connect(): void {
  closeAll();
  const events = new EventSource(`${BASE}/api/v1/events`);
  events.onopen = () => {
    if (missed) tellReset(); // whatever happened meanwhile
    missed = false;
    useConnection.setState({ status: "open" });
  };
  events.onerror = () => {
    missed = true;
    useConnection.setState({ status: "lost" });
  };
  for (const kind of KINDS) {
    events.addEventListener(kind, (message) => tellEvent(JSON.parse(message.data) as Schema<"EventInfo">));
  }
  events.addEventListener("reset", () => tellReset());
  const state = new EventSource(`${BASE}/api/v1/robots/state/stream?rate=${STATE_RATE}`);
  state.addEventListener("state", (message) => useStation.getState().take(JSON.parse(message.data)));
  streams = [events, state];
}

/** Follows nothing any more: a page that nobody sees shall not hold connections, of which a browser has six. */
export function disconnect(): void {
  missed = true;
  closeAll();
}

/** Whether the browser has given up a stream (the server refused it), so that somebody has to connect anew. */
export function givenUp(): boolean {
  return streams.length === 0 || streams.some((stream) => stream.readyState === EventSource.CLOSED);
}

function closeAll(): void {
  for (const stream of streams) stream.close();
  streams = [];
}
