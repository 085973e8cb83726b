import { Tabs as MantineTabs } from "@mantine/core";
import { IconBox, IconListCheck, IconPuzzle, IconTargetArrow } from "@tabler/icons-react";
import { lazy } from "react";
import { useTranslation } from "react-i18next";
import { Part } from "./Part";
import classes from "./Tabs.module.css";
import { TABS, type Tab, useTab } from "./useTab";

const ICONS = { goal: IconTargetArrow, task: IconListCheck, modules: IconPuzzle, world: IconBox };
const CONTENTS = {
  goal: lazy(() => import("../goal/GoalTab")),
  task: lazy(() => import("../task/TaskTab")),
  modules: lazy(() => import("../modules/ModulesTab")),
  world: lazy(() => import("../world/WorldTab")),
};

export function Tabs() {
  const { t } = useTranslation();
  const [tab, open] = useTab();
  const Content = CONTENTS[tab];
  return (
    <MantineTabs value={tab} onChange={(value) => open(value as Tab)} keepMounted={false} className={classes.tabs}>
      <MantineTabs.List aria-label={t("tabs.label")}>
        {TABS.map((name) => {
          const Icon = ICONS[name];
          return (
            <MantineTabs.Tab key={name} value={name} leftSection={<Icon size={16} aria-hidden />}>
              {t(`tabs.${name}`)}
            </MantineTabs.Tab>
          );
        })}
      </MantineTabs.List>
      {TABS.map((name) => (
        <MantineTabs.Panel key={name} value={name} className={classes.panel}>
          {name === tab && (
            <Part>
              <Content />
            </Part>
          )}
        </MantineTabs.Panel>
      ))}
    </MantineTabs>
  );
}
