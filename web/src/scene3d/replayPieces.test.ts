import { LENGTH, type Piece, Pieces } from "./replayPieces";

const REPLAY = { job: "kit-1", start: 10, end: 10 + 3.5 * LENGTH } as Piece;

function asked(fails: () => boolean = () => false) {
  const starts: number[] = [];
  const onRead = vi.fn();
  const read = (start: number, end: number) => {
    starts.push((start - REPLAY.start) / LENGTH);
    return fails() ? Promise.reject(new Error("lost")) : Promise.resolve({ start, end } as Piece);
  };
  return { pieces: new Pieces(REPLAY, read, onRead), starts, onRead };
}

const settled = () => vi.advanceTimersByTimeAsync(0);

beforeEach(() => void vi.useFakeTimers());
afterEach(() => void vi.useRealTimers());

test("only the pieces of the current time and the next one are fetched, once", async () => {
  const { pieces, starts, onRead } = asked();
  expect(pieces.at(REPLAY.start)).toBeUndefined();
  await settled();
  expect(pieces.at(REPLAY.start + 1)?.start).toBe(REPLAY.start);
  await settled();
  expect([starts, onRead.mock.calls.length]).toEqual([[0, 1], 2]);
});

test("there is no piece after the last one", async () => {
  const { pieces, starts } = asked();
  pieces.at(REPLAY.end);
  await settled();
  expect(starts).toEqual([3]);
});

test("while a slider moves fast, only pieces at its current position are fetched", async () => {
  const { pieces, starts } = asked();
  for (const share of [0, 1, 2, 3]) pieces.at(REPLAY.start + share * LENGTH);
  await settled();
  expect(starts).toEqual([0, 3]);
});

test("failed requests are repeated until the replay is closed", async () => {
  let broken = true;
  const { pieces, starts } = asked(() => broken);
  pieces.at(REPLAY.end);
  await vi.advanceTimersByTimeAsync(1500);
  expect(starts).toEqual([3, 3]);
  broken = false;
  await vi.advanceTimersByTimeAsync(1000);
  expect(pieces.at(REPLAY.end)).toBeDefined();

  const left = asked(() => true);
  left.pieces.at(REPLAY.end);
  left.pieces.close();
  await vi.advanceTimersByTimeAsync(5000);
  expect(left.starts).toEqual([3]);
});
