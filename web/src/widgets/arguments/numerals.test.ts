import { isNoNumber, numberIn, stepped } from "./numerals";

test.each([
  ["1.5", 1.5],
  ["1,5", 1.5],
  [" -,25 ", -0.25],
  ["−3", -3],
  ["2e-3", 0.002],
  ["", undefined],
])("%j is the number %j", (text, number) => {
  expect(numberIn(text)).toBe(number);
});

test.each(["1e999", "1.000,5", "12abc", "0x10", "Infinity", "1 5"])("%j is not a number, not even in part", (text) => {
  expect(numberIn(text)).toBeNaN();
  expect(isNoNumber(text)).toBe(true);
});

test.each(["-", ".", "-,", "1e", "1e-"])("%j is not a number yet, but no fault either", (text) => {
  expect(numberIn(text)).toBeNaN();
  expect(isNoNumber(text)).toBe(false);
});

test("counts are integers", () => {
  expect(numberIn("3", true)).toBe(3);
  expect(numberIn("1,5", true)).toBeNaN();
});

test("steps stay within the limits, without rounding noise", () => {
  expect(stepped(0.1, 0.2)).toBe(0.3);
  expect(stepped(9.5, 1, { max: 10 })).toBe(10);
  expect(stepped(undefined, -1, { min: 1 })).toBe(1);
});
