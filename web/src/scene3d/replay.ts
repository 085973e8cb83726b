/** The replay of a past job in the 3D view. */

import { create } from "zustand";
import { answer, api } from "../api/client";
import { type Piece, Pieces } from "./replayPieces";

interface Replay {
  /** The replay's data except frames; null in the present. */
  replay: Piece | null;
  /** The last fetched piece around the current time. */
  piece: Piece | null;
  /** Whether the piece of the current time is being fetched. */
  waits: boolean;
  /** The time shown [s, run time of the replay]. */
  time: number;
  /** Speed of the replay; 0 while it is paused. */
  speed: number;
  set: (change: Partial<Pick<Replay, "replay" | "time" | "speed">>) => void;
}

export const useReplay = create<Replay>((set) => ({
  replay: null,
  piece: null,
  waits: false,
  time: 0,
  speed: 0,
  set: (change) => set(change),
}));

let pieces: { replay: Piece; of: Pieces } | null = null;

/** Starts the replay of a job. */
export async function showReplay(job: string): Promise<void> {
  const read = async (start: number, end: number) => {
    const params = { path: { id: job }, query: { start, end } };
    return (await answer(api.GET("/api/v1/jobs/{id}/replay", { params }))) as Piece; // tuples lose their length there
  };
  const replay = await read(0, 0);
  pieces?.of.close();
  pieces = { replay, of: new Pieces(replay, read, follow) };
  useReplay.setState({ replay, piece: replay, time: replay.start, speed: 0 });
}

/** Keeps the piece of the current time loaded. */
function follow(): void {
  const { replay, piece, waits, time } = useReplay.getState();
  if (pieces === null || pieces.replay !== replay) {
    pieces?.of.close();
    pieces = null;
    return;
  }
  const there = pieces.of.at(time);
  const next = there ?? piece;
  if (next !== piece || waits !== (there === undefined)) {
    useReplay.setState({ piece: next, waits: there === undefined });
  }
}

useReplay.subscribe(follow);
