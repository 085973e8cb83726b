import { Text } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { useTranslation } from "react-i18next";
import { answer, api } from "../api/client";
import { usePretends } from "../api/cell";
import { keys } from "../api/keys";
import { useLoginEnded } from "../api/session";
import { useConnection } from "../live/connection";
import { useStation } from "../live/station";
import { Status } from "../widgets/Status";
import { clock, movingRobots, rounded } from "./stationTexts";

const SLOW = 0.9; // below this part of its pace the simulation is slow

/** Simulated time of the station, and its pace: also the one measured, where that is another one. */
export function StationClock() {
  const { t } = useTranslation("always");
  const seconds = useStation(({ state }) => (state === null ? null : Math.floor(state.time)));
  const pace = useStation(({ state }) => state?.pace);
  const rate = useStation(({ rate: measured }) => (measured === null ? null : rounded(measured)));
  if (seconds === null) return null;
  const slow = rate !== null && pace != null && rate < SLOW * pace;
  const reached = rate !== null && (slow || pace === null) ? t("clock.pace", { pace: rate }) : "";
  const wanted = pace === null ? t("clock.free") : t("clock.pace", { pace });
  return (
    <Text size="sm" component="span" role="timer" aria-label={t("clock.label")} title={t("clock.label")}>
      {t("clock.simulated", { time: clock(seconds) })} {reached} {slow ? t("clock.instead", { wanted }) : wanted}
    </Text>
  );
}

/** Which robots move. */
export function RobotsState() {
  const { t } = useTranslation("always");
  const { data: robots } = useQuery({
    queryKey: keys.robots(),
    queryFn: async () => (await answer(api.GET("/api/v1/robots"))).items,
  });
  const known = useStation(({ state }) => state !== null);
  const current = useConnection(({ status, silent }) => status === "open" && silent === null);
  const moving = useStation(({ state }) => movingRobots(state, robots ?? []));
  const pretends = usePretends();
  if (!known || robots === undefined) return null;
  if (robots.length === 0) return <Status mood="waiting" text={t("robots.none")} />;
  if (!current) return <Status mood="waiting" text={t("robots.unknown")} />;
  const said = moving === "" ? t("robots.stand", { count: robots.length }) : t("robots.move", { names: moving });
  return (
    <Status mood={moving === "" ? "waiting" : "running"} text={pretends ? t("robots.pretended", { said }) : said} />
  );
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
