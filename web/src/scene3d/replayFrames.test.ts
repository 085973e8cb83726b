import { describe, expect, it } from "vitest";
import type { Schema } from "../api/client";
import type { Devices } from "./devices";
import { framesAt, PastViews } from "./replayFrames";
import { element, world } from "./testing";

const FRAMES: Schema<"ReplayFrames"> = {
  times: [1, 2, 4],
  joints: { "robot/shoulder": [0, 1, 3], "robot/left": [0.04, 0.02, 0.02], "table/turn": [0, 2, 2] },
  frames: {
    base: [upright(0, 0, 3), upright(1, 0, -3), upright(1, 0, -3)],
    table: [
      [0, 2, 0.5, 0, 0, 0, 1],
      [0, 2, 0.5, 0, 0, -1, 0],
      [0, 2, 0.5, 0, 0, -1, 0],
    ],
  },
  states: {},
};

function upright(x: number, y: number, heading: number): number[] {
  return [x, y, 0, 0, 0, Math.sin(heading / 2), Math.cos(heading / 2)];
}

function devicesAt(time: number): Devices {
  const into: Devices = { frames: {}, joints: {} };
  framesAt({ frames: FRAMES, changes: [] } as unknown as Schema<"Replay">, time, into);
  return into;
}

describe("devices between two frames of a replay", () => {
  it("are interpolated linearly", () => {
    expect(devicesAt(1.5).joints["robot/shoulder"]).toEqual([0.5]);
    expect(devicesAt(3).joints["robot/shoulder"]).toEqual([2]);
    expect(devicesAt(1.25).joints["robot/left"]?.[0]).toBeCloseTo(0.035);
  });

  it("include the joints of all kinds, with or without a robot", () => {
    expect(devicesAt(1.5).joints["table/turn"]).toEqual([1]);
  });

  it("rotate the short way round", () => {
    const [x, , , , , z, w] = devicesAt(1.5).frames["base"] ?? [];
    expect(x).toBeCloseTo(0.5);
    expect(Math.cos(2 * Math.atan2(z ?? 0, w ?? 0))).toBeCloseTo(-1);
  });

  it("of any kind have the poses of their frames", () => {
    const [, y, height, , , z, w] = devicesAt(1.5).frames["table"] ?? [];
    expect([y, height]).toEqual([2, 0.5]);
    expect([z, w].map(Math.abs as (part?: number) => number)).toEqual([
      expect.closeTo(Math.SQRT1_2),
      expect.closeTo(Math.SQRT1_2),
    ]);
  });

  it("keep their poses before the first and after the last frame", () => {
    expect(devicesAt(0).joints["robot/shoulder"]).toEqual([0]);
    expect(devicesAt(9).joints["robot/shoulder"]).toEqual([3]);
  });
});

describe("devices while a job was interrupted", () => {
  const continued = { time: 4.00001, author: "", whole: true, view: world([]) };
  const replay = { frames: FRAMES, changes: [continued] } as unknown as Schema<"Replay">;
  const angleAt = (time: number) => {
    const into: Devices = { frames: {}, joints: {} };
    framesAt(replay, time, into);
    return into.joints["robot/shoulder"]?.[0];
  };

  it("keep their last poses, then jump to the next recorded ones", () => {
    expect([1.5, 2, 3, 3.99, 4, 9].map(angleAt)).toEqual([0.5, 1, 1, 1, 3, 3]);
  });
});

describe("the world of a replay", () => {
  const change = (time: number, place: string) => ({ time, author: "pick", view: world([element("a", { place })]) });
  const replay = {
    beginning: world([element("a", { place: "pallet" })]),
    changes: [change(2, "gripper"), change(5, "kit")],
  } as unknown as Schema<"Replay">;
  const places = (times: number[]) => {
    const past = new PastViews(replay);
    return times.map((time) => past.at(time).elements.get("a")?.place);
  };

  it("follows the time, forwards and backwards", () => {
    expect(places([0, 2, 4.9, 5, 9, 3, 1])).toEqual([
      "pallet",
      "gripper",
      "gripper",
      "kit",
      "kit",
      "gripper",
      "pallet",
    ]);
  });

  it("is replaced when the job continues: elements missing from the new view are gone, but shapes are kept", () => {
    const beginning = world([element("a"), element("b", { shape: "box" })], { shapes: { box: [] } });
    const view = world([element("b", { shape: "box", place: "floor" }), element("c", { shape: "rod" })], {
      shapes: { rod: [] },
    });
    const went = { time: 5, author: "", whole: true, view };
    const past = new PastViews({ beginning, changes: [change(2, "gripper"), went] } as unknown as Schema<"Replay">);
    expect([...past.at(4.9).elements.keys()]).toEqual(["a", "b"]);
    expect([...past.at(5).elements.values()].map(({ id, place }) => [id, place])).toEqual([
      ["b", "floor"],
      ["c", null],
    ]);
    expect(Object.keys(past.at(5).shapes)).toEqual(["box", "rod"]);
    expect([...past.at(1).elements.keys()]).toEqual(["a", "b"]);
  });

  it("is the same object until something changes", () => {
    const past = new PastViews(replay);
    expect(past.at(2.5)).toBe(past.at(4.5));
  });
});
