import { IconKeyOff, IconPlugConnectedX } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { useLoginEnded } from "../api/session";
import { useConnection } from "../live/connection";
import { Moment } from "../widgets/Moment";
import { Banner } from "./Banner";

/** The server is lost or sends no states of the robots, so the page may be out of date. Disappears after recovery. */
export function ConnectionBanner() {
  const { t } = useTranslation("always");
  const { status, since, silent } = useConnection();
  const lost = status === "lost";
  if (useLoginEnded()) {
    return (
      <Banner tone="orange" icon={IconKeyOff} title={t("connection.signedOut")}>
        {t("connection.signedOutText")}
      </Banner>
    );
  }
  if (!lost && silent === null) return null;
  return (
    <Banner tone="orange" icon={IconPlugConnectedX} title={lost ? t("connection.lost") : t("connection.silent")}>
      {t("connection.since")} <Moment at={lost ? since : silent} />.{" "}
      {lost ? t("connection.lostText") : t("connection.silentText")}
    </Banner>
  );
}
