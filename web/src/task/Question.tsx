import { Alert, Group, Text } from "@mantine/core";
import { Answers } from "../always/Answers";
import { useAlarms } from "../always/useAlarms";
import type { Schema } from "../api/client";
import { ServerText } from "../goal/ServerText";

/** The question that a job asks a person; empty without one. */
export function Question({ job }: { job: Schema<"Job"> }) {
  const alarm = useAlarms(true).find((one) => one.job === job.id && one.choices.length > 0);
  if (alarm === undefined || job.choices.length === 0) return null;
  return (
    <Alert color="orange" p="xs">
      <Group gap="xs" justify="space-between">
        <Text size="sm">
          <ServerText text={alarm.text} />
        </Text>
        <Answers alarm={alarm} />
      </Group>
    </Alert>
  );
}
