import { ActionIcon, Checkbox, CopyButton, Group, Popover, Stack, TextInput, Tooltip } from "@mantine/core";
import { IconCheck, IconCopy, IconEye, IconPlayerPlay, IconSettings } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { BASE } from "../api/client";
import { useMe } from "../api/session";
import { CountField } from "../widgets/arguments/CountField";
import { MayButton } from "../widgets/MayButton";
import { curl } from "../widgets/shell";
import { type Options, useDraft } from "./draft";
import classes from "./goal.module.css";
import type { GoalOrder } from "./goals";
import { jobOrder, useOrder } from "./order";

interface Props {
  /** The goal; null while it is incomplete. */
  order: GoalOrder | null;
  planning: boolean;
  onPreview: () => void;
}

/** Preview, run, and their options. */
export function RunBar({ order, planning, onPreview }: Props) {
  const { t } = useTranslation("goal");
  const { draft } = useDraft();
  const run = useOrder();
  const { data: me } = useMe();
  const ordered = order && jobOrder(order, draft.options);
  return (
    <Group gap="xs" className={classes.actions} role="group" aria-label={t("run.group")}>
      <MayButton
        operation="ask_preview"
        variant="default"
        leftSection={<IconEye size={16} aria-hidden />}
        disabled={order === null}
        loading={planning}
        onClick={onPreview}
      >
        {t("run.preview")}
      </MayButton>
      <MayButton
        operation="order_job"
        color="green"
        leftSection={<IconPlayerPlay size={16} aria-hidden />}
        disabled={ordered === null}
        loading={run.isPending}
        onClick={() => ordered && run.mutate(ordered)}
      >
        {t("run.run")}
      </MayButton>
      <RunOptions />
      <CopyButton value={ordered ? curl(`${BASE}/api/v1/jobs`, ordered, me?.keys_needed ?? false) : ""}>
        {({ copied, copy }) => (
          <Tooltip label={copied ? t("run.copied") : t("run.curl")}>
            <ActionIcon aria-label={t("run.curl")} disabled={ordered === null} onClick={copy}>
              {copied ? <IconCheck size={16} aria-hidden /> : <IconCopy size={16} aria-hidden />}
            </ActionIcon>
          </Tooltip>
        )}
      </CopyButton>
    </Group>
  );
}

function RunOptions() {
  const { t } = useTranslation("goal");
  const { draft, change } = useDraft();
  const { options } = draft;
  const set = (part: Partial<Options>) => change({ options: { ...options, ...part } });
  const setPolicy = (part: Partial<Options["policy"]>) => set({ policy: { ...options.policy, ...part } });
  return (
    <Popover position="top-start" shadow="md" trapFocus withinPortal>
      <Popover.Target>
        <Tooltip label={t("options.title")}>
          <ActionIcon aria-label={t("options.title")} variant="default" size="30">
            <IconSettings size={16} aria-hidden />
          </ActionIcon>
        </Tooltip>
      </Popover.Target>
      <Popover.Dropdown aria-label={t("options.title")}>
        <Stack gap="xs" maw={340}>
          <TextInput
            label={t("options.description")}
            maxLength={2000}
            value={options.description}
            onChange={(event) => set({ description: event.currentTarget.value })}
          />
          <CountField
            label={t("options.priority")}
            description={t("options.priorityHelp")}
            min={-32768}
            max={32767}
            value={options.priority}
            onChange={(priority) => set({ priority })}
          />
          <CountField
            label={t("options.attempts")}
            min={1}
            max={1000}
            value={options.policy.attempts}
            onChange={(attempts) => setPolicy({ attempts })}
          />
          {(["rest", "ask", "partial", "rehearse"] as const).map((name) => (
            <Checkbox
              key={name}
              size="xs"
              label={t(`options.${name}`)}
              checked={options.policy[name]}
              onChange={(event) => setPolicy({ [name]: event.currentTarget.checked })}
            />
          ))}
        </Stack>
      </Popover.Dropdown>
    </Popover>
  );
}
