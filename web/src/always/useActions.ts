import type { SpotlightActionGroupData } from "@mantine/spotlight";
import { keepPreviousData, useQuery } from "@tanstack/react-query";
import { useTranslation } from "react-i18next";
import { answer, api } from "../api/client";
import { keys } from "../api/keys";
import { useMe } from "../api/session";
import { TABS, useOpenAsLeft, useTab } from "../app/useTab";
import { useSelection } from "../selection/selection";
import { useDialogs } from "./dialogs";
import { logout } from "./logout";
import { useOtherLanguage, useScheme } from "./Preferences";
import { stopAll } from "./stopping";

const FOUND = 12;
const JOBS = 200;

/** The actions of the command palette for a search text, in groups. Fetches nothing while the palette is closed. */
export function useActions(searched: string, opened: boolean): SpotlightActionGroupData[] {
  return [useTabs(), useCommands(), useElements(searched, opened), useJobs(opened), useScenes(opened)];
}

function useTabs(): SpotlightActionGroupData {
  const { t } = useTranslation();
  const openTab = useOpenAsLeft();
  const actions = TABS.map((tab) => ({ id: `tab-${tab}`, label: t(`tabs.${tab}`), onClick: () => openTab(tab) }));
  return { group: t("tabs.label"), actions };
}

function useCommands(): SpotlightActionGroupData {
  const { t } = useTranslation("always");
  const { data: me } = useMe();
  const language = useOtherLanguage();
  const scheme = useScheme();
  const open = useDialogs((dialogs) => dialogs.open);
  const actions = [
    { id: "stop", label: t("stop.label"), onClick: () => void stopAll(t("stop.reason")) },
    { id: "reset", label: t("reset.label"), onClick: () => open("reset") },
    { id: "alarms", label: t("alarms.title"), onClick: () => open("alarms") },
    { id: "help", label: t("help.open"), onClick: () => open("help") },
    { id: "language", label: t("language", { name: language.name }), onClick: language.change },
    { id: "scheme", label: scheme.dark ? t("light") : t("dark"), onClick: scheme.change },
  ];
  if (me?.keys_needed) actions.push({ id: "logout", label: t("user.logout"), onClick: () => void logout() });
  return { group: t("palette.commands"), actions };
}

function useElements(searched: string, opened: boolean): SpotlightActionGroupData {
  const { t } = useTranslation("always");
  const [, openTab] = useTab();
  const { data } = useQuery({
    queryKey: keys.world("palette", searched),
    queryFn: () => answer(api.GET("/api/v1/elements", { params: { query: { text: searched, limit: FOUND } } })),
    enabled: opened && searched !== "",
    placeholderData: keepPreviousData,
  });
  const show = (id: string) => {
    useSelection.getState().choose(id);
    openTab("world");
  };
  const found = searched === "" ? [] : (data?.items ?? []);
  const actions = found.map(({ id, label }) => ({
    id: `element-${id}`,
    label: label || id,
    description: id,
    keywords: [searched], // the server has matched it, in whichever field
    onClick: () => show(id),
  }));
  return { group: t("palette.elements"), actions };
}

function useJobs(enabled: boolean): SpotlightActionGroupData {
  const { t } = useTranslation("always");
  const [, openTab] = useTab();
  const { data } = useQuery({
    queryKey: keys.jobs("palette"),
    queryFn: () => answer(api.GET("/api/v1/jobs", { params: { query: { limit: JOBS, newest_first: true } } })),
    enabled,
  });
  const actions = (data?.items ?? []).map(({ id, state }) => ({
    id: `job-${id}`,
    label: id,
    description: state.text,
    onClick: () => openTab("task", id),
  }));
  return { group: t("palette.jobs"), actions };
}

function useScenes(enabled: boolean): SpotlightActionGroupData {
  const { t } = useTranslation("always");
  const open = useDialogs((dialogs) => dialogs.open);
  const { data } = useQuery({
    queryKey: keys.scenes("palette"),
    queryFn: () => answer(api.GET("/api/v1/scenes", { params: { query: { limit: 100 } } })),
    enabled,
  });
  const actions = (data?.items ?? []).map(({ name }) => ({
    id: `scene-${name}`,
    label: t("palette.load", { name }),
    onClick: () => open("load", name),
  }));
  return { group: t("palette.scenes"), actions };
}
