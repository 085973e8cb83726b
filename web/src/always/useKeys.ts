import { useEffect } from "react";
import { useTranslation } from "react-i18next";
import { toggleView3d } from "../app/layout";
import { useOpenAsLeft } from "../app/useTab";
import { useSelection } from "../selection/selection";
import { useDialogs } from "./dialogs";
import { usePalette } from "./palette";
import { type Command, commandOf } from "./shortcuts";
import { stopAll } from "./stopping";
import { pressed } from "../widgets/history";

/** Handles keyboard shortcuts before any other listener. */
export function useKeys(): void {
  const { t } = useTranslation("always");
  const openTab = useOpenAsLeft();
  useEffect(() => {
    const run = (command: Command) => {
      if (command === "stop") void stopAll(t("stop.reason"));
      else if (command === "palette") usePalette.getState().open();
      else if (command === "help") useDialogs.getState().open("help");
      else if (command === "view3d") toggleView3d();
      else if (command === "undo" || command === "redo") pressed(command);
      else openTab(command.tab);
    };
    const hear = (event: KeyboardEvent) => {
      if (event.key === "Escape") useSelection.getState().endPick();
      const command = commandOf(event, isWriting(event.target));
      if (command === undefined) return;
      event.preventDefault();
      event.stopPropagation();
      if (!event.repeat) run(command);
    };
    window.addEventListener("keydown", hear, { capture: true });
    return () => window.removeEventListener("keydown", hear, { capture: true });
  }, [t, openTab]);
}

function isWriting(target: EventTarget | null): boolean {
  return (
    target instanceof HTMLElement &&
    (target.isContentEditable || (/^(INPUT|TEXTAREA|SELECT)$/.test(target.tagName) && !target.matches("[readonly]")))
  );
}
