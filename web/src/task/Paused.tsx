import { Alert, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import type { Schema } from "../api/client";
import { ServerText } from "../goal/ServerText";
import { Moment } from "../widgets/Moment";
import { useTransitions } from "./useRun";

/** Since when and why a job is paused that asks nothing, such as by a person or a full disk. */
export function Paused({ job }: { job: Schema<"Job"> }) {
  const { t } = useTranslation("task");
  const { data } = useTransitions(job);
  const last = data?.items.at(-1);
  if (job.state.text !== "Interrupted" || job.choices.length > 0 || last?.state.text !== "Interrupted") return null;
  return (
    <Alert color="orange" p="xs" role="status">
      <Text size="sm">
        {t("job.pausedAt")} <Moment at={last.at} />
        {last.comment !== "" && ": "}
        <ServerText text={last.comment} />
      </Text>
    </Alert>
  );
}
