import { commandOf } from "./shortcuts";

const PLAIN = { code: "", key: "", ctrlKey: false, metaKey: false, altKey: false, shiftKey: false };

test("Ctrl+Shift+Space stops, in a text field, too", () => {
  expect(commandOf({ ...PLAIN, code: "Space", key: " ", ctrlKey: true, shiftKey: true }, true)).toBe("stop");
});

test.each([{ shiftKey: true }, { ctrlKey: true }, { altKey: true, shiftKey: true }, {}])(
  "a space with less does not stop: %o",
  (held) => {
    expect(commandOf({ ...PLAIN, ...held, code: "Space", key: " " }, false)).toBeUndefined();
  },
);

test("Alt and a digit open a tab, whatever the layout makes of them", () => {
  expect(commandOf({ ...PLAIN, code: "Digit2", key: "™", altKey: true }, true)).toEqual({ tab: "task" });
  expect(commandOf({ ...PLAIN, code: "Digit9", key: "9", altKey: true }, true)).toBeUndefined();
});

test("AltGr and a digit write a character and open nothing", () => {
  expect(commandOf({ ...PLAIN, code: "Digit2", key: "²", altKey: true, ctrlKey: true }, true)).toBeUndefined();
});

test("a question mark shows the keys, unless it is written", () => {
  expect(commandOf({ ...PLAIN, key: "?", shiftKey: true }, false)).toBe("help");
  expect(commandOf({ ...PLAIN, key: "?", shiftKey: true }, true)).toBeUndefined();
});
