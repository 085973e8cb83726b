import { describe, expect, it } from "vitest";
import { headingOf, inMap, numbersOf, poseFrom, seenFrom } from "./pose";
import type { MapPose } from "./tools";

const NUMBERS = { x: 1.25, y: -0.5, z: 0.4, roll: 10, pitch: -20, yaw: 135 };

describe("poses in numbers", () => {
  it("come back as they were written", () => {
    expect(numbersOf(poseFrom(NUMBERS))).toEqual(NUMBERS);
  });

  it("turn about the fixed axes of their frame: yaw is the heading", () => {
    expect(headingOf(poseFrom({ ...NUMBERS, roll: 0, pitch: 0 }))).toBeCloseTo((135 / 180) * Math.PI);
  });
});

describe("a pose in a frame", () => {
  const frame: MapPose = poseFrom({ x: 5, y: 1, z: 0, roll: 0, pitch: 0, yaw: 90 });
  const ahead: MapPose = poseFrom({ x: 5, y: 3, z: 0.5, roll: 0, pitch: 0, yaw: 90 });

  it("is told from there", () => {
    expect(numbersOf(seenFrom(ahead, frame))).toEqual({ x: 2, y: 0, z: 0.5, roll: 0, pitch: 0, yaw: 0 });
  });

  it("comes back to the map", () => {
    expect(numbersOf(inMap(seenFrom(ahead, frame), frame))).toEqual(numbersOf(ahead));
  });
});
