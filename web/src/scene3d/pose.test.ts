import { describe, expect, it } from "vitest";
import { headingOf, inMap, numbersOf, poseFrom, seenFrom } from "./pose";
import type { MapPose } from "./tools";

const NUMBERS = { x: 1.25, y: -0.5, z: 0.4, roll: 10, pitch: -20, yaw: 135 };

describe("poses in numbers", () => {
  it("are the same after a round trip", () => {
    expect(numbersOf(poseFrom(NUMBERS))).toEqual(NUMBERS);
  });

  it("rotate about the fixed axes of their frame: yaw is the heading", () => {
    expect(headingOf(poseFrom({ ...NUMBERS, roll: 0, pitch: 0 }))).toBeCloseTo((135 / 180) * Math.PI);
  });
});

describe("a pose in a frame", () => {
  const frame: MapPose = poseFrom({ x: 5, y: 1, z: 0, roll: 0, pitch: 0, yaw: 90 });
  const ahead: MapPose = poseFrom({ x: 5, y: 3, z: 0.5, roll: 0, pitch: 0, yaw: 90 });

  it("is computed relative to the frame", () => {
    expect(numbersOf(seenFrom(ahead, frame))).toEqual({ x: 2, y: 0, z: 0.5, roll: 0, pitch: 0, yaw: 0 });
  });

  it("can be converted back to the map", () => {
    expect(numbersOf(inMap(seenFrom(ahead, frame), frame))).toEqual(numbersOf(ahead));
  });
});
