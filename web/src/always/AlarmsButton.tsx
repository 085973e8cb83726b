import { Badge, Button } from "@mantine/core";
import { IconBell } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { useDialogs } from "./dialogs";
import { gravest } from "./severity";
import { useAlarms } from "./useAlarms";

/** The number of active alarms and their highest severity; opens the list. */
export function AlarmsButton() {
  const { t } = useTranslation("always");
  const open = useDialogs((dialogs) => dialogs.open);
  const alarms = useAlarms(true);
  const grave = gravest(alarms);
  const urgent = grave === "critical" || grave === "high";
  return (
    <Button
      variant={urgent ? "light" : "subtle"}
      color={urgent ? "red" : "gray"}
      leftSection={<IconBell size={16} aria-hidden />}
      rightSection={
        alarms.length > 0 && (
          <Badge circle color={urgent ? "red" : "gray"} aria-hidden>
            {alarms.length}
          </Badge>
        )
      }
      aria-label={t("alarms.open", { count: alarms.length })}
      onClick={() => open("alarms")}
    >
      {t("alarms.title")}
    </Button>
  );
}
