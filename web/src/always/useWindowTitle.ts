import { useDocumentTitle, useDocumentVisibility } from "@mantine/hooks";
import { useTranslation } from "react-i18next";
import { useConnection } from "../live/connection";
import { useStation } from "../live/station";
import { windowTitle } from "./stationTexts";
import { useAlarms } from "./useAlarms";

/** Shows the state in the title of the browser's tab. */
export function useWindowTitle(): void {
  const { t } = useTranslation("always");
  const lost = useConnection(({ status }) => status === "lost");
  const questions = useAlarms(true).filter(({ choices }) => choices.length > 0).length;
  const words = {
    lost: t("title.lost"),
    asks: t("title.asks"),
    halted: t("title.halted"),
    running: t("title.running"),
  };
  // Hidden pages are disconnected: an old state must not look like the current one.
  const hidden = useDocumentVisibility() === "hidden";
  useDocumentTitle(
    useStation(({ state }) => windowTitle(hidden ? null : state, lost && !hidden, hidden ? 0 : questions, words)),
  );
}
