import { Box3, Vector3 } from "three";
import { surfaceAt } from "./surfaces";

const ground = (x: number, top: number, hollow = false, bottom = 0) => ({
  box: new Box3(new Vector3(x - 1, -1, bottom), new Vector3(x + 1, 1, top)),
  hollow,
});

test("an element is set down on what is highest below it, in a cavity on its bottom, otherwise on the floor", () => {
  const grounds = [ground(0, 0.7), ground(0.5, 0.8), ground(3, 0.9), ground(3, 0.9, true, 0.75)];
  expect(surfaceAt(grounds, [0, 0, 5])).toBe(0.8);
  expect(surfaceAt(grounds, [-0.9, 0, 5])).toBe(0.7);
  expect(surfaceAt(grounds, [3, 0, 5])).toBe(0.75);
  expect(surfaceAt(grounds, [9, 0, 5])).toBe(0);
});
