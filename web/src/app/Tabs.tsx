import { ActionIcon, Tabs as MantineTabs, Tooltip } from "@mantine/core";
import {
  IconBox,
  IconLayoutSidebarLeftCollapse,
  IconLayoutSidebarLeftExpand,
  IconListCheck,
  IconPuzzle,
  IconTargetArrow,
} from "@tabler/icons-react";
import { lazy, type RefObject, useEffect, useLayoutEffect, useRef } from "react";
import { useTranslation } from "react-i18next";
import { toggleView3d, useView3d } from "./layout";
import { Part } from "./Part";
import classes from "./Tabs.module.css";
import { leave, TABS, type Tab, useOpenAsLeft, useTab } from "./useTab";

const ICONS = { goal: IconTargetArrow, task: IconListCheck, modules: IconPuzzle, world: IconBox };
const CONTENTS = {
  goal: lazy(() => import("../goal/GoalTab")),
  task: lazy(() => import("../task/TaskTab")),
  modules: lazy(() => import("../modules/ModulesTab")),
  world: lazy(() => import("../world/WorldTab")),
};

export function Tabs() {
  const { t } = useTranslation();
  const [tab, , detail] = useTab();
  const open = useOpenAsLeft();
  const Content = CONTENTS[tab];
  const list = useRef<HTMLDivElement>(null);
  useFocusOn(tab, list);
  useEffect(() => leave(tab, detail), [tab, detail]);
  return (
    <MantineTabs value={tab} onChange={(value) => open(value as Tab)} keepMounted={false} className={classes.tabs}>
      <div className={classes.bar}>
        <View3dButton />
        <MantineTabs.List ref={list} aria-label={t("tabs.label")} className={classes.list}>
          {TABS.map((name) => {
            const Icon = ICONS[name];
            return (
              <MantineTabs.Tab key={name} value={name} leftSection={<Icon size={16} aria-hidden />}>
                {t(`tabs.${name}`)}
              </MantineTabs.Tab>
            );
          })}
        </MantineTabs.List>
      </div>
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

/** Focuses a tab that was opened by a key, since the focused element disappeared with the other panel. */
function useFocusOn(tab: Tab, list: RefObject<HTMLElement | null>): void {
  const before = useRef(tab);
  useLayoutEffect(() => {
    if (before.current === tab) return;
    before.current = tab;
    if (document.activeElement !== document.body) return;
    list.current?.querySelector<HTMLElement>("[role=tab][aria-selected=true]")?.focus();
  }, [tab, list]);
}

function View3dButton() {
  const { t } = useTranslation();
  const view3d = useView3d();
  const label = view3d ? t("hide3d") : t("show3d");
  const Icon = view3d ? IconLayoutSidebarLeftCollapse : IconLayoutSidebarLeftExpand;
  return (
    <Tooltip label={label}>
      <ActionIcon aria-label={label} aria-expanded={view3d} onClick={toggleView3d}>
        <Icon size={18} />
      </ActionIcon>
    </Tooltip>
  );
}
