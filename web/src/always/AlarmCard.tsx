import { Anchor, Group, Paper, Stack, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { detailOf } from "../task/address";
import { MayButton } from "../widgets/MayButton";
import { Moment } from "../widgets/Moment";
import { Status } from "../widgets/Status";
import { Answers } from "./Answers";
import { MOODS } from "./severity";
import { type Alarm, useAcknowledge } from "./useAlarms";
import { ServerText } from "../goal/ServerText";
import { said } from "../i18n/sentences";

/** One alarm: severity, text, time, acknowledgement, and the possible actions. */
export function AlarmCard({ alarm }: { alarm: Alarm }) {
  const { t } = useTranslation("always");
  return (
    <Paper withBorder p="xs" component="article" aria-label={said(alarm.text)}>
      <Stack gap={6}>
        <Group gap="xs">
          <Status mood={MOODS[alarm.severity]} text={t(`severity.${alarm.severity}`)} />
          <Text size="xs" c="dimmed">
            {alarm.source} · <Moment at={alarm.since} /> {alarm.until && "– "}
            <Moment at={alarm.until} />
          </Text>
        </Group>
        <Text size="sm">
          <ServerText text={alarm.text} />
        </Text>
        <Acts alarm={alarm} />
      </Stack>
    </Paper>
  );
}

function Acts({ alarm }: { alarm: Alarm }) {
  const { t } = useTranslation("always");
  const acknowledging = useAcknowledge();
  return (
    <Group gap="xs">
      {alarm.active && alarm.choices.length > 0 && <Answers alarm={alarm} />}
      {alarm.acknowledged ? (
        <Text size="xs">{t("alarms.seen", { name: alarm.by })}</Text>
      ) : (
        <MayButton
          operation="acknowledge_alarm"
          variant="default"
          loading={acknowledging.isPending}
          onClick={() => acknowledging.mutate(alarm)}
        >
          {t("alarms.acknowledge")}
        </MayButton>
      )}
      <Where alarm={alarm} />
    </Group>
  );
}

/** The page that shows the subject of an alarm. */
function Where({ alarm }: { alarm: Alarm }) {
  const { t } = useTranslation("always");
  if (alarm.job) {
    return (
      <Anchor size="sm" href={`#/task/${encodeURIComponent(alarm.job)}`}>
        {t("alarms.job", { job: alarm.job })}
      </Anchor>
    );
  }
  if (alarm.kind === "task") {
    return (
      <Anchor size="sm" href={`#/task/${encodeURIComponent(detailOf({ kind: "task", id: alarm.source }))}`}>
        {t("alarms.task", { task: alarm.source })}
      </Anchor>
    );
  }
  if (alarm.kind !== "module" && alarm.kind !== "manager") return null;
  return (
    <Anchor size="sm" href="#/modules">
      {t("alarms.modules")}
    </Anchor>
  );
}
