import { Alert, Badge, Group, Loader, Stack, Text, Title } from "@mantine/core";
import { IconArrowsSplit2 } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { MayButton } from "../widgets/MayButton";
import { useWorldInfo } from "../world/queries";
import classes from "./goal.module.css";
import type { CheckedCondition, GoalOrder } from "./goals";
import { intoView } from "../widgets/intoView";
import type { Preview } from "./preview";
import { clock } from "./steps";
import { StepText } from "./StepText";
import { WhyNot } from "./WhyNot";

interface Props {
  preview: Preview | undefined;
  planning: boolean;
  lost: boolean;
  /** Whether the plan belongs to the current goal. */
  fits: boolean;
  conditions: readonly CheckedCondition[];
  /** Plans again, for another goal if one is given. */
  again: (order?: GoalOrder | null) => void;
}

/** The plan in words, or the reasons why there is none. */
export function PreviewPanel({ preview, planning, lost, fits, conditions, again }: Props) {
  const { t } = useTranslation("goal");
  return (
    <Stack
      gap="xs"
      component="section"
      ref={intoView}
      className={classes.result}
      aria-label={t("preview.title")}
      aria-live="polite"
      aria-busy={planning}
    >
      <Title order={3} size="h5">
        {t("preview.title")}
      </Title>
      {planning && (
        <Group gap="xs">
          <Loader size="xs" aria-hidden />
          <Text size="sm">{t("preview.planning")}</Text>
        </Group>
      )}
      {lost && <Text size="sm">{t("preview.lost")}</Text>}
      {!planning && preview && !fits && <Alert color="yellow">{t("preview.other")}</Alert>}
      {!planning && fits && preview && <Older planned={preview.world} again={() => again()} />}
      {!planning && preview?.state === "planned" && <Plan preview={preview} />}
      {!planning && fits && preview && (preview.state === "no plan" || preview.state === "failed") && (
        <WhyNot preview={preview} conditions={conditions} again={again} />
      )}
    </Stack>
  );
}

/** Reports that the world has changed since the plan was made. */
function Older({ planned, again }: { planned: number; again: () => void }) {
  const { t } = useTranslation("goal");
  const { data } = useWorldInfo();
  if (data === undefined || data.version === planned) return null;
  return (
    <Alert color="yellow">
      <Group justify="space-between" gap="xs">
        <Text size="sm">{t("preview.older", { planned, now: data.version })}</Text>
        <MayButton operation="ask_preview" variant="default" onClick={again}>
          {t("preview.again")}
        </MayButton>
      </Group>
    </Alert>
  );
}

function Plan({ preview: { steps, wall, planner, notes } }: { preview: Preview }) {
  const { t } = useTranslation("goal");
  if (steps.length === 0) return <Text size="sm">{t("preview.nothing")}</Text>;
  return (
    <>
      <ol className={classes.steps} aria-label={t("preview.steps")}>
        {steps.map((step, index) => (
          <li key={index} className={classes.step}>
            <Text span size="xs" c="dimmed" ta="right">
              {index + 1}
            </Text>
            <Text span size="sm">
              <StepText step={step} />
              {isBeside(step.after, index) && (
                <Badge ml={6} size="xs" variant="light" leftSection={<IconArrowsSplit2 size={10} aria-hidden />}>
                  {step.after.length === 0 ? t("preview.atOnce") : t("preview.after", { steps: listed(step.after) })}
                </Badge>
              )}
            </Text>
            <Text span size="xs" c="dimmed">
              {step.start === null ? "" : clock(step.start)}
            </Text>
          </li>
        ))}
      </ol>
      <Text size="xs" c="dimmed">
        {t("preview.by", { planner: planner || t("preview.nobody"), wall: (wall ?? 0).toFixed(2) })}
      </Text>
      {notes.map((note) => (
        <Text key={note} size="xs" c="dimmed">
          {note}
        </Text>
      ))}
    </>
  );
}

/** Whether a step has other predecessors than the step before it. */
function isBeside(after: readonly number[], index: number): boolean {
  return index > 0 && !(after.length === 1 && after[0] === index - 1);
}

function listed(after: readonly number[]): string {
  return after.map((index) => index + 1).join(", ");
}
