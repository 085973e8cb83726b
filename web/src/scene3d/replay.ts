/** A past job that is shown in the 3D view instead of the present. */

import { create } from "zustand";
import { answer, api } from "../api/client";
import { type Piece, Pieces } from "./replayPieces";

interface Replay {
  /** What is shown again, read without its middle; null for the present. */
  replay: Piece | null;
  /** What was read last of where the replay is. */
  piece: Piece | null;
  /** Whether the piece of this moment is still being read. */
  waits: boolean;
  /** The moment that is shown [s, run time of the replay]. */
  time: number;
  /** How fast it goes on; 0 while it stands. */
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

/** Shows a job again, from its start. */
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

/** Keeps the piece that is shown where the time is. */
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
