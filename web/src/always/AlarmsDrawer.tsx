import { Drawer, Stack, Tabs, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { AlarmCard } from "./AlarmCard";
import { useDialogs } from "./dialogs";
import { bySeverity } from "./severity";
import { type Alarm, useAlarms } from "./useAlarms";

const SHOWN = 100;

/** All active and past alarms, newest first. */
export function AlarmsDrawer() {
  const { t } = useTranslation("always");
  const { opened, close } = useDialogs();
  return (
    <Drawer opened={opened === "alarms"} onClose={close} title={t("alarms.title")} position="right" size="lg">
      <Tabs defaultValue="active" keepMounted={false}>
        <Tabs.List mb="sm">
          <Tabs.Tab value="active">{t("alarms.active")}</Tabs.Tab>
          <Tabs.Tab value="past">{t("alarms.past")}</Tabs.Tab>
        </Tabs.List>
        <Tabs.Panel value="active">
          <Active />
        </Tabs.Panel>
        <Tabs.Panel value="past">
          <Past />
        </Tabs.Panel>
      </Tabs>
    </Drawer>
  );
}

function Active() {
  return <List alarms={bySeverity(useAlarms(true))} />;
}

function Past() {
  return <List alarms={useAlarms(false).slice(-SHOWN).toReversed()} />;
}

function List({ alarms }: { alarms: readonly Alarm[] }) {
  const { t } = useTranslation("always");
  if (alarms.length === 0) return <Text size="sm">{t("alarms.none")}</Text>;
  return (
    <Stack gap="xs">
      {alarms.map((alarm) => (
        <AlarmCard key={alarm.id} alarm={alarm} />
      ))}
    </Stack>
  );
}
