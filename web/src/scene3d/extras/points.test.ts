import { describe, expect, it } from "vitest";
import { thinned } from "./points";

const places = Float32Array.from({ length: 15 }, (_, i) => i); // five points
const colours = places.map((value) => value + 100);

describe("a thinned cloud", () => {
  it("keeps whole points in order, each with its colour", () => {
    const cloud = thinned({ places, colours }, 3);
    expect([...cloud.places]).toEqual([0, 1, 2, 6, 7, 8, 12, 13, 14]);
    expect([...(cloud.colours ?? [])]).toEqual([100, 101, 102, 106, 107, 108, 112, 113, 114]);
  });

  it("is the original if it has few enough points", () => {
    expect(thinned({ places, colours: null }, 5)).toEqual({ places, colours: null });
  });
});
