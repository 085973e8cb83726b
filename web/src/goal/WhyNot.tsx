import { Alert, Stack, Text, Title } from "@mantine/core";
import { IconBulb, IconX } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { causeOf } from "./causes";
import type { CheckedCondition, GoalOrder } from "./goals";
import type { Preview } from "./preview";
import { Reason } from "./Reason";
import { RepairCard } from "./RepairCard";
import { ServerText } from "./ServerText";

interface Props {
  preview: Preview;
  /** The conditions of the current goal. */
  conditions: readonly CheckedCondition[];
  /** Plans again. */
  again: (order?: GoalOrder | null) => void;
}

/** Why there is no plan, and possible repairs. */
export function WhyNot({ preview, conditions, again }: Props) {
  const { t } = useTranslation("goal");
  const named = preview.causes.flatMap((cause) => causeOf(cause).named);
  return (
    <>
      <Alert
        color="red"
        icon={<IconX size={18} aria-hidden />}
        title={preview.state === "failed" ? t("whyNot.failed") : t("whyNot.title")}
      >
        <Stack gap="sm">
          {preview.causes.map((cause, index) => (
            <Reason key={index} cause={cause} conditions={conditions} />
          ))}
          {preview.causes.length === 0 &&
            preview.reasons.map((reason) => (
              <Text key={reason} size="sm">
                <ServerText text={reason} />
              </Text>
            ))}
        </Stack>
      </Alert>
      {preview.repairs.length > 0 && (
        <Stack gap="xs" component="section" aria-label={t("repair.title")}>
          <Title order={4} size="h6">
            <IconBulb size={16} aria-hidden /> {t("repair.title")}
          </Title>
          {preview.repairs.map((repair) => (
            <RepairCard
              key={repair.id}
              preview={preview.id}
              repair={repair}
              conditions={conditions}
              named={named}
              again={again}
            />
          ))}
        </Stack>
      )}
    </>
  );
}
