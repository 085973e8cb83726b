import { Tabs } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { useMay } from "../api/session";
import { useTab } from "../app/useTab";
import { DevicesPanel } from "./devices/DevicesPanel";
import { JogPanel } from "./jog/JogPanel";
import classes from "./modules.module.css";
import { TryModules } from "./module/TryModules";
import { detailOf, placeOf, type View, VIEWS } from "./places";
import { Plugins } from "./plugins/Plugins";
import { RunHistory } from "./runs/RunHistory";

/** The Modules tab: running single modules, jogging, teaching, devices and plug-ins (Fig. 6 of the paper). */
export default function ModulesTab() {
  const { t } = useTranslation("modules");
  const [, open, detail] = useTab();
  const place = placeOf(detail);
  const mayPlugins = useMay("list_plugins");
  const show = (view: View, ...rest: string[]) => open("modules", detailOf(view, ...rest));
  const contents: Record<View, () => React.ReactNode> = {
    try: () => <TryModules place={place} show={show} />,
    jog: () => <JogPanel chosen={place.rest[0]} show={show} />,
    devices: () => <DevicesPanel show={show} />,
    runs: () => <RunHistory chosen={place.rest[0]} show={show} />,
    plugins: () => <Plugins />,
  };
  return (
    <Tabs value={place.view} onChange={(view) => show(view as View)} keepMounted={false} className={classes.tab}>
      <Tabs.List aria-label={t("views.label")}>
        {VIEWS.filter((view) => view !== "plugins" || mayPlugins).map((view) => (
          <Tabs.Tab key={view} value={view}>
            {t(`views.${view}`)}
          </Tabs.Tab>
        ))}
      </Tabs.List>
      <Tabs.Panel value={place.view} className={classes.content}>
        {contents[place.view]()}
      </Tabs.Panel>
    </Tabs>
  );
}
