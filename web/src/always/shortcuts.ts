/** The keyboard shortcuts: their commands, and their descriptions for people. */

import { TABS, type Tab } from "../app/address";

export type Command = "stop" | "palette" | "help" | "view3d" | "undo" | "redo" | { tab: Tab };

type Press = Pick<KeyboardEvent, "code" | "key" | "ctrlKey" | "metaKey" | "altKey" | "shiftKey">;

/**
 * Returns the command of a key press; undefined if there is none.
 *
 * @param writing - Whether the focus is in a text field, where plain letters are no commands, and which undoes by itself.
 */
export function commandOf(press: Press, writing: boolean): Command | undefined {
  const control = press.ctrlKey || press.metaKey;
  if (control && press.shiftKey && press.code === "Space") return "stop";
  if (control && !press.altKey && !press.shiftKey && press.code === "KeyK") return "palette";
  if (control && !press.altKey && !writing && press.key.toLowerCase() === "z") return press.shiftKey ? "redo" : "undo";
  if (!control && press.altKey && !press.shiftKey) return withAlt(press.code);
  return !control && !press.altKey && !writing && press.key === "?" ? "help" : undefined;
}

function withAlt(code: string): Command | undefined {
  if (code === "Digit0") return "view3d";
  const tab = TABS[Number(/^Digit([1-9])$/.exec(code)?.[1] ?? 0) - 1];
  return tab && { tab };
}

/** Text keys of the shortcuts, with their keys, by the part of the page; for the help dialog. */
export const SHORTCUTS = {
  everywhere: [
    ["stop", ["Ctrl", "Shift", "Space"]],
    ["palette", ["Ctrl", "K"]],
    ["tabs", ["Alt", "1 … 4"]],
    ["view3d", ["Alt", "0"]],
    ["undo", ["Ctrl", "Z"]],
    ["redo", ["Ctrl", "Shift", "Z"]],
    ["help", ["?"]],
    ["escape", ["Esc"]],
    ["panes", ["Tab", "←", "→"]],
  ],
  picture: [
    ["turn", ["←", "→", "↑", "↓"]],
    ["nearer", ["+", "−"]],
    ["views", ["O", "T", "R", "F"]],
  ],
  tree: [
    ["walk", ["↑", "↓"]],
    ["branch", ["→", "←"]],
    ["choose", ["Enter"]],
  ],
  steps: [["reorder", ["Space", "↑", "↓", "Space"]]],
} as const;
