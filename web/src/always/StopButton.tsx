import { Button, Tooltip } from "@mantine/core";
import { IconHandStop } from "@tabler/icons-react";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { useMay } from "../api/session";
import classes from "./always.module.css";
import { stopAll } from "./stopping";

/** Stops everything at once: no confirmation, no queue, above everything else on the page. */
export function StopButton() {
  const { t } = useTranslation("always");
  const { t: common } = useTranslation();
  const may = useMay("stop");
  const [hinted, setHinted] = useState(false);
  const show = () => setHinted(true);
  const hide = () => setHinted(false);
  return (
    <Tooltip
      opened={hinted}
      label={may ? t("stop.hint") : common("mayNot")}
      multiline
      maw={280}
      position="right"
      zIndex={10_001}
    >
      <Button
        className={classes.stop}
        color="red"
        size="md"
        aria-label={t("stop.label")}
        aria-keyshortcuts="Control+Shift+Space"
        leftSection={<IconHandStop size={22} aria-hidden />}
        // Users without permission see the reason; the request is sent all the same, and the server decides.
        data-disabled={!may || undefined}
        aria-disabled={!may}
        onMouseEnter={show}
        onMouseLeave={hide}
        onFocus={({ currentTarget }) => currentTarget.matches(":focus-visible") && show()}
        onBlur={hide}
        onClick={() => {
          hide(); // otherwise it covers the result of the stop
          void stopAll(t("stop.reason"));
        }}
      >
        {t("stop.label")}
      </Button>
    </Tooltip>
  );
}
