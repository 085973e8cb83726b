import { lazy, useEffect } from "react";
import { useTranslation } from "react-i18next";
import { AlarmsDrawer } from "../always/AlarmsDrawer";
import { Banners } from "../always/Banners";
import { Header } from "../always/Header";
import { HelpDialog } from "../always/HelpDialog";
import { LoadSceneDialog } from "../always/LoadSceneDialog";
import { usePalette } from "../always/palette";
import { ResetDialog } from "../always/ResetDialog";
import { useKeys } from "../always/useKeys";
import { useWindowTitle } from "../always/useWindowTitle";
import { keepFocus } from "./focus";
import { Panes } from "./Panes";
import { Part } from "./Part";

const Palette = lazy(() => import("../always/Palette"));

/** The layout of the page: the header above, the live 3D view and the four tabs below. */
export function Shell() {
  const { t } = useTranslation();
  const paletteAsked = usePalette(({ asked }) => asked > 0);
  useEffect(keepFocus, []); // before all other listeners of keys
  useKeys();
  useWindowTitle();
  return (
    <div className="shell">
      <a
        className="skip"
        href="#main"
        onClick={(event) => {
          event.preventDefault(); // the address names a tab
          document.getElementById("main")?.focus();
        }}
      >
        {t("skip")}
      </a>
      <Header />
      <Banners />
      <Panes />
      <ResetDialog />
      <LoadSceneDialog />
      <HelpDialog />
      <AlarmsDrawer />
      {paletteAsked && (
        <Part>
          <Palette />
        </Part>
      )}
    </div>
  );
}
