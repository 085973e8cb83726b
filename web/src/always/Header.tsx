import { ActionIcon, Title, Tooltip } from "@mantine/core";
import { IconCommand, IconKeyboard } from "@tabler/icons-react";
import { useQuery } from "@tanstack/react-query";
import { useTranslation } from "react-i18next";
import { answer, api } from "../api/client";
import { keys } from "../api/keys";
import classes from "./always.module.css";
import { AlarmsButton } from "./AlarmsButton";
import { useDialogs } from "./dialogs";
import { usePalette } from "./palette";
import { LanguageButton, SchemeButton } from "./Preferences";
import { ConnectionState, RobotsState, StationClock } from "./StationStates";
import { StopButton } from "./StopButton";
import { UserMenu } from "./UserMenu";

/** The header of all pages: stop-all, state of the station, alarms, user. */
export function Header() {
  const { t } = useTranslation("always");
  const openDialog = useDialogs((dialogs) => dialogs.open);
  const openPalette = usePalette((palette) => palette.open);
  return (
    <header className={classes.header}>
      <StopButton />
      <SceneName />
      <StationClock />
      <RobotsState />
      <ConnectionState />
      <div className={classes.grow} />
      <AlarmsButton />
      <Tooltip label={t("palette.open")}>
        <ActionIcon aria-label={t("palette.open")} onClick={openPalette}>
          <IconCommand size={18} />
        </ActionIcon>
      </Tooltip>
      <Tooltip label={t("help.open")}>
        <ActionIcon aria-label={t("help.open")} onClick={() => openDialog("help")}>
          <IconKeyboard size={18} />
        </ActionIcon>
      </Tooltip>
      <LanguageButton />
      <SchemeButton />
      <UserMenu />
    </header>
  );
}

function SceneName() {
  const { t } = useTranslation("always");
  const { data } = useQuery({ queryKey: keys.station("scene"), queryFn: () => answer(api.GET("/api/v1/scene")) });
  return (
    <Title order={1} size="h5">
      {data?.name || t("scene")}
    </Title>
  );
}
