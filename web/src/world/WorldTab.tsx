import { Tabs } from "@mantine/core";
import { IconBooks, IconDatabaseSearch, IconFolder, IconSitemap } from "@tabler/icons-react";
import { lazy } from "react";
import { useTranslation } from "react-i18next";
import { Part } from "../app/Part";
import { SceneView } from "./SceneView";
import { type View, useView, VIEWS } from "./useView";
import classes from "./World.module.css";

const ICONS = { scene: IconSitemap, ontology: IconBooks, query: IconDatabaseSearch, scenes: IconFolder };
const CONTENTS = {
  scene: SceneView,
  ontology: lazy(() => import("../ontology/OntologyBrowser")),
  query: lazy(() => import("../ontology/query/QueryConsole")),
  scenes: lazy(() => import("./scenes/ScenesView")),
};

/** The World tab: the scene, the ontology, queries, and the scenes that can be loaded. */
export default function WorldTab() {
  const { t } = useTranslation("world");
  const [view, , open] = useView();
  const Content = CONTENTS[view];
  return (
    <Tabs value={view} onChange={(value) => open(value as View)} keepMounted={false} className={classes.world}>
      <Tabs.List aria-label={t("views.label")}>
        {VIEWS.map((name) => {
          const Icon = ICONS[name];
          return (
            <Tabs.Tab key={name} value={name} leftSection={<Icon size={14} aria-hidden />}>
              {t(`views.${name}`)}
            </Tabs.Tab>
          );
        })}
      </Tabs.List>
      {VIEWS.map((name) => (
        <Tabs.Panel key={name} value={name} className={classes.panel}>
          {name === view && (
            <Part>
              <Content />
            </Part>
          )}
        </Tabs.Panel>
      ))}
    </Tabs>
  );
}
