import { Text } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { useTranslation } from "react-i18next";
import { answer, api } from "../api/client";
import { keys } from "../api/keys";
import { useLoginEnded } from "../api/session";
import { useConnection } from "../live/connection";
import { useStation } from "../live/station";
import { Status } from "../widgets/Status";
import { clock, movingRobots } from "./stationTexts";

/** Time and pace of the station. */
export function StationClock() {
  const { t } = useTranslation("always");
  const seconds = useStation(({ state }) => (state === null ? null : Math.floor(state.time)));
  const pace = useStation(({ state }) => state?.pace);
  if (seconds === null) return null;
  return (
    <Text size="sm" component="span" role="timer" aria-label={t("clock.label")}>
      {clock(seconds)} {pace === null ? t("clock.free") : t("clock.pace", { pace })}
    </Text>
  );
}

/** Which robots move. */
export function RobotsState() {
  const { t } = useTranslation("always");
  const { data: robots } = useQuery({ queryKey: keys.robots(), queryFn: () => answer(api.GET("/api/v1/robots")) });
  const known = useStation(({ state }) => state !== null);
  const moving = useStation(({ state }) => movingRobots(state, robots ?? []));
  if (!known || robots === undefined) return null;
  if (robots.length === 0) return <Status mood="waiting" text={t("robots.none")} />;
  if (moving === "") return <Status mood="waiting" text={t("robots.stand", { count: robots.length })} />;
  return <Status mood="running" text={t("robots.move", { names: moving })} />;
}

export function ConnectionState() {
  const { t } = useTranslation("always");
  const ended = useLoginEnded();
  const connection = useConnection(({ status }) => status);
  const status = ended ? "signedOut" : connection;
  const mood = { open: "good", connecting: "waiting", lost: "bad", signedOut: "bad" } as const;
  return (
    <span role="status">
      <Status mood={mood[status]} text={t(`connected.${status}`)} />
    </span>
  );
}
