import { commandOf } from "./shortcuts";

const PLAIN = { code: "", key: "", ctrlKey: false, metaKey: false, altKey: false, shiftKey: false };

test("Ctrl+Shift+Space stops, even in a text field", () => {
  expect(commandOf({ ...PLAIN, code: "Space", key: " ", ctrlKey: true, shiftKey: true }, true)).toBe("stop");
});

test.each([{ shiftKey: true }, { ctrlKey: true }, { altKey: true, shiftKey: true }, {}])(
  "a space with less does not stop: %o",
  (held) => {
    expect(commandOf({ ...PLAIN, ...held, code: "Space", key: " " }, false)).toBeUndefined();
  },
);

test("Alt and a digit open a tab in any keyboard layout", () => {
  expect(commandOf({ ...PLAIN, code: "Digit2", key: "™", altKey: true }, true)).toEqual({ tab: "task" });
  expect(commandOf({ ...PLAIN, code: "Digit9", key: "9", altKey: true }, true)).toBeUndefined();
});

test("AltGr and a digit write a character and open no tab", () => {
  expect(commandOf({ ...PLAIN, code: "Digit2", key: "²", altKey: true, ctrlKey: true }, true)).toBeUndefined();
});

test("a question mark shows the keys, except in a text field", () => {
  expect(commandOf({ ...PLAIN, key: "?", shiftKey: true }, false)).toBe("help");
  expect(commandOf({ ...PLAIN, key: "?", shiftKey: true }, true)).toBeUndefined();
});

test("Ctrl+Z undoes and Ctrl+Shift+Z redoes, except in a text field, which has its own", () => {
  const press = { ...PLAIN, code: "KeyZ", ctrlKey: true };
  expect(commandOf({ ...press, key: "z" }, false)).toBe("undo");
  expect(commandOf({ ...press, key: "Z", shiftKey: true }, false)).toBe("redo");
  expect(commandOf({ ...press, key: "z" }, true)).toBeUndefined();
});
