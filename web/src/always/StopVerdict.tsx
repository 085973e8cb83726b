import { Button, Text } from "@mantine/core";
import { IconAlertOctagon, IconCheck, IconHandStop, type TablerIcon } from "@tabler/icons-react";
import { useEffect } from "react";
import { useTranslation } from "react-i18next";
import { keys } from "../api/keys";
import { queryClient } from "../api/queries";
import { onEvent } from "../live/events";
import classes from "./always.module.css";
import { stopAll, useStopping, type Verdict } from "./stopping";
import { said } from "../i18n/sentences";

const ICONS: Record<Verdict, TablerIcon> = {
  asking: IconHandStop,
  noAnswer: IconAlertOctagon,
  notObeyed: IconAlertOctagon,
  refused: IconAlertOctagon,
  signedOut: IconAlertOctagon,
  unsent: IconHandStop,
  obeyed: IconCheck,
};

/** The result of a stop requested here, in large type: an ineffective stop must not go unnoticed. */
export function StopVerdict() {
  const { verdict } = useStopping();
  const forget = useStopping((stopping) => stopping.forget);
  useEffect(() => {
    if (verdict !== "obeyed") return;
    return onEvent(({ kind, type }) => void (kind === "system" && type === "reset" && forget()));
  }, [verdict, forget]);
  // Then the login form is needed at once.
  useEffect(() => {
    if (verdict === "signedOut") void queryClient.invalidateQueries({ queryKey: keys.me });
  }, [verdict]);
  return <div role="alert">{verdict && <Words verdict={verdict} />}</div>;
}

function Words({ verdict }: { verdict: Verdict }) {
  const { t } = useTranslation("always");
  const { text, forget } = useStopping();
  const Icon = ICONS[verdict];
  const unsent = verdict === "signedOut" || verdict === "unsent";
  const good = verdict === "obeyed" || verdict === "asking";
  return (
    <div className={classes.verdict} data-bad={!good || undefined}>
      <Icon size={32} aria-hidden />
      <div className={classes.bannerText}>
        <Text fz={22} fw={800} lh={1.2}>
          {t(`verdict.${verdict}.title`)}
        </Text>
        <Text size="md">
          {t(`verdict.${verdict}.text`)} {said(text)}
        </Text>
      </div>
      {unsent && (
        <Button variant="white" color="red" onClick={() => void stopAll(t("stop.reason"))}>
          {t("verdict.stopNow")}
        </Button>
      )}
      {verdict !== "asking" && (
        <Button variant="white" color="dark" onClick={forget}>
          {verdict === "noAnswer" || unsent ? t("verdict.withdraw") : t("verdict.seen")}
        </Button>
      )}
    </div>
  );
}
