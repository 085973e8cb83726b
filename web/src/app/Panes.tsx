import { useMantineTheme } from "@mantine/core";
import { useMediaQuery } from "@mantine/hooks";
import { lazy } from "react";
import { useTranslation } from "react-i18next";
import { Group, Panel, Separator, useDefaultLayout } from "react-resizable-panels";
import { useView3d } from "./layout";
import { Part } from "./Part";
import { PickNotice } from "./PickNotice";
import { Tabs } from "./Tabs";

const Scene = lazy(() => import("../scene3d/Scene"));
const BOTH = ["view3d", "tabs"];
const ONE = ["tabs"];

/** The 3D view, if shown, next to the tabs; remembers their widths. */
export function Panes() {
  const { t } = useTranslation();
  const { breakpoints } = useMantineTheme();
  const narrow = useMediaQuery(`(max-width: ${breakpoints.sm})`);
  const view3d = useView3d();
  const layout = useDefaultLayout({
    id: narrow ? "skiros-panes-narrow" : "skiros-panes",
    panelIds: view3d ? BOTH : ONE,
    storage: localStorage,
  });
  return (
    <Group {...layout} orientation={narrow ? "vertical" : "horizontal"}>
      {view3d && (
        <>
          <Panel id="view3d" defaultSize="50%" minSize="20%" className="pane">
            <section aria-label={t("view3d")} className="pane">
              <Part>
                <Scene />
              </Part>
            </section>
          </Panel>
          <Separator className="divider" aria-label={t("divider")} />
        </>
      )}
      <Panel id="tabs" minSize="30%" className="pane">
        <main id="main" tabIndex={-1} className="pane main">
          <PickNotice />
          <Tabs />
        </main>
      </Panel>
    </Group>
  );
}
