/** Syntax colours, legible on light and dark backgrounds. */

import { HighlightStyle } from "@codemirror/language";
import { tags } from "@lezer/highlight";

export const COLOURS = HighlightStyle.define([
  {
    tag: [tags.keyword, tags.operatorKeyword, tags.function(tags.variableName)],
    color: shade("violet"),
    fontWeight: "bold",
  },
  { tag: [tags.variableName, tags.special(tags.variableName)], color: shade("blue") },
  { tag: [tags.string, tags.special(tags.string)], color: shade("red") },
  { tag: [tags.number, tags.bool, tags.atom], color: shade("teal") },
  { tag: [tags.namespace, tags.url, tags.link, tags.propertyName], color: shade("cyan") },
  { tag: tags.comment, color: "var(--mantine-color-dimmed)", fontStyle: "italic" },
  { tag: tags.invalid, textDecoration: "underline wavy" },
]);

function shade(colour: string): string {
  return `light-dark(var(--mantine-color-${colour}-9), var(--mantine-color-${colour}-3))`;
}
