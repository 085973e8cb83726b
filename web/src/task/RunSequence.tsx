import { Checkbox, Group } from "@mantine/core";
import { IconPlayerPlay } from "@tabler/icons-react";
import { useQueryClient } from "@tanstack/react-query";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, api, type Schema } from "../api/client";
import { keys } from "../api/keys";
import { useSingleMutation } from "../api/mutations";
import { useTab } from "../app/useTab";
import { CountField } from "../widgets/arguments/CountField";
import { MayButton } from "../widgets/MayButton";
import { detailOf } from "./address";
import { Problem } from "./Problem";
import { Section } from "./Section";
import type { Sequence } from "./sequences";

const MOST = 1_000_000;

/** Runs a sequence repeatedly, and opens the new task. */
export function RunSequence({ sequence: { id, count, works } }: { sequence: Sequence }) {
  const { t } = useTranslation("task");
  const [, open] = useTab();
  const client = useQueryClient();
  const [times, setTimes] = useState(1);
  const [endless, setEndless] = useState(false);
  const [anyway, setAnyway] = useState(false);
  const { mutate, isPending, error } = useSingleMutation({
    mutationFn: () => {
      const body = { sequence: id, iterate: endless ? null : times, anyway };
      return answer(api.POST("/api/v1/tasks", { body: body as Schema<"NewTask"> }));
    },
    onSuccess: ({ name }) => {
      void client.invalidateQueries({ queryKey: keys.tasks() });
      open("task", detailOf({ kind: "task", id: name }));
    },
  });
  return (
    <Section title={t("run.title")}>
      <Group gap="md" align="end">
        <CountField
          label={t("run.times")}
          value={times}
          min={1}
          max={MOST}
          w={90}
          disabled={endless}
          onChange={setTimes}
        />
        <Checkbox size="xs" label={t("run.endless")} checked={endless} onChange={() => setEndless(!endless)} mb={6} />
        {!works && count > 0 && (
          <Checkbox size="xs" label={t("run.anyway")} checked={anyway} onChange={() => setAnyway(!anyway)} mb={6} />
        )}
        <MayButton
          operation="begin_task"
          leftSection={<IconPlayerPlay size={14} aria-hidden />}
          disabled={count === 0 || (!works && !anyway)}
          loading={isPending}
          onClick={() => mutate()}
        >
          {t("run.run")}
        </MayButton>
      </Group>
      {error !== null && <Problem error={error} />}
    </Section>
  );
}
