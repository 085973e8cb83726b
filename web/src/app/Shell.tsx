import { useMantineTheme } from "@mantine/core";
import { useMediaQuery } from "@mantine/hooks";
import { lazy } from "react";
import { useTranslation } from "react-i18next";
import { Group, Panel, Separator } from "react-resizable-panels";
import { Banners } from "../always/Banners";
import { Header } from "../always/Header";
import { Part } from "./Part";
import { Tabs } from "./Tabs";

const Scene = lazy(() => import("../scene3d/Scene"));

/** The one screen: what is always there above, the live 3D view beside the four tabs below. */
export function Shell() {
  const { t } = useTranslation();
  const { breakpoints } = useMantineTheme();
  const narrow = useMediaQuery(`(max-width: ${breakpoints.sm})`);
  return (
    <div className="shell">
      <Header />
      <Banners />
      <Group orientation={narrow ? "vertical" : "horizontal"}>
        <Panel defaultSize="50%" minSize="20%" className="pane">
          <section aria-label={t("view3d")} className="pane">
            <Part>
              <Scene />
            </Part>
          </section>
        </Panel>
        <Separator className="divider" />
        <Panel minSize="30%" className="pane">
          <Tabs />
        </Panel>
      </Group>
    </div>
  );
}
