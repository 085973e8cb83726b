import { Group } from "@mantine/core";
import { useTranslation } from "react-i18next";
import type { Schema } from "../api/client";
import { Moment } from "../widgets/Moment";

/** The times at which a job was ordered, started and ended. */
export function JobTimes({ job }: { job: Schema<"Job"> }) {
  const { t } = useTranslation("task");
  return (
    <Group gap="md" fz="sm" c="dimmed">
      {(["ordered", "started", "ended"] as const).map(
        (name) =>
          job[name] !== null && (
            <span key={name}>
              {t(`job.${name}`)} <Moment at={job[name]} />
            </span>
          ),
      )}
      {job.attempts > 1 && <span>{t("job.attempts", { count: job.attempts })}</span>}
    </Group>
  );
}
