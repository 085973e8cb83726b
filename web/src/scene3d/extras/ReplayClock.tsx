import { useFrame } from "@react-three/fiber";
import { useEffect } from "react";
import { useReplay } from "../replay";
import { wake } from "../ticker";

const SHORT = 200; // ms: duration for which frames are requested
const MOST = 0.25; // s: a page that was hidden does not jump

/** Advances a replay, waits for pieces that are being fetched, and stops at the end. */
export function ReplayClock() {
  const replay = useReplay((state) => state.replay);
  const time = useReplay((state) => state.time);
  const speed = useReplay((state) => state.speed);
  const piece = useReplay((state) => state.piece);
  useEffect(() => wake(speed > 0 ? SHORT : 0), [replay, piece, time, speed]);
  useFrame((_, delta) => {
    const now = useReplay.getState();
    if (now.replay === null || now.speed <= 0 || now.waits) return;
    const then = now.time + Math.min(delta, MOST) * now.speed;
    const ended = then >= now.replay.end;
    now.set({ time: ended ? now.replay.end : then, ...(ended && { speed: 0 }) });
  }, -5);
  return null;
}
