import { Button } from "@mantine/core";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { useTakeUp } from "../goal/useTakeUp";
import { ConfirmDialog } from "../widgets/ConfirmDialog";

/** Opens the goal of a job in the Goal tab, which shows repairs; asks before it replaces a draft. */
export function TakeUp({ goal }: { goal: readonly string[] }) {
  const { t } = useTranslation("task");
  const [asking, setAsking] = useState(false);
  const { take, busy, overwrites } = useTakeUp();
  return (
    <>
      <Button variant="default" mt={6} loading={busy} onClick={() => (overwrites ? setAsking(true) : take(goal))}>
        {t("job.toGoal")}
      </Button>
      {asking && (
        <ConfirmDialog
          title={t("job.toGoal")}
          text={t("job.replacesDraft")}
          action={t("job.replaceDraft")}
          onConfirm={() => take(goal)}
          onClose={() => setAsking(false)}
        />
      )}
    </>
  );
}
