import { Alert, Button, Card, Group, List, Stack, Text, Title } from "@mantine/core";
import { IconBulb, IconX } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { answer, api } from "../api/client";
import { useSingleMutation } from "../api/mutations";
import { ElementName } from "../widgets/ElementName";
import { MayButton } from "../widgets/MayButton";
import { notifyProblem } from "../widgets/problems";
import { notifyChange } from "../widgets/undo";
import { useDraft } from "./draft";
import { type CheckedCondition, type GoalOrder, goalOrder, isSame, keyed, without } from "./goals";
import type { Preview } from "./preview";

interface Props {
  preview: Preview;
  /** The conditions that are wanted now. */
  conditions: readonly CheckedCondition[];
  /** Plans anew. */
  again: (order?: GoalOrder | null) => void;
}

type Repair = Preview["repairs"][number];

/** Why there is no plan, and what would help. */
export function WhyNot({ preview, conditions, again }: Props) {
  const { t } = useTranslation("goal");
  return (
    <>
      <Alert
        color="red"
        icon={<IconX size={18} aria-hidden />}
        title={preview.state === "failed" ? t("whyNot.failed") : t("whyNot.title")}
      >
        <List size="sm" spacing={4}>
          {preview.reasons.map((reason, index) => (
            <List.Item key={reason}>
              {reason}
              <About elements={elementsOf(preview.causes[index])} />
            </List.Item>
          ))}
        </List>
      </Alert>
      {preview.repairs.length > 0 && (
        <Stack gap="xs" component="section" aria-label={t("repair.title")}>
          <Title order={4} size="h6">
            <IconBulb size={16} aria-hidden /> {t("repair.title")}
          </Title>
          {preview.repairs.map((repair) => (
            <RepairCard key={repair.id} preview={preview.id} repair={repair} conditions={conditions} again={again} />
          ))}
        </Stack>
      )}
    </>
  );
}

/** The elements that a reason is about, to be looked at in the 3D view. */
function About({ elements }: { elements: readonly string[] }) {
  if (elements.length === 0) return null;
  return (
    <Group gap={8} mt={2}>
      {elements.map((id) => (
        <Text key={id} span size="xs">
          <ElementName id={id} />
        </Text>
      ))}
    </Group>
  );
}

function elementsOf(cause: Record<string, unknown> | undefined): string[] {
  const named: unknown = cause?.elements;
  if (!Array.isArray(named)) return [];
  return named.filter((one): one is string => typeof one === "string" && !one.includes(":"));
}

interface CardProps {
  preview: string;
  repair: Repair;
  conditions: readonly CheckedCondition[];
  again: (order?: GoalOrder | null) => void;
}

function RepairCard({ preview, repair, conditions, again }: CardProps) {
  const { t } = useTranslation("goal");
  const { setRows } = useDraft();
  const make = useSingleMutation({
    mutationFn: () =>
      answer(
        api.POST("/api/v1/previews/{id}/repairs/{number}/apply", {
          params: { path: { id: preview, number: repair.id } },
        }),
      ),
    onSuccess: ({ text, world }) => {
      notifyChange(t("repair.done", { text }), world);
      again();
    },
    onError: notifyProblem,
  });
  const rest = without(conditions, repair.without);
  const leaveOut = () => {
    setRows(rest);
    again(goalOrder(keyed(rest)));
  };
  const found = repair.without.every((one) => conditions.some(({ text }) => isSame(one, text)));
  const canLeaveOut = repair.edits.length === 0 && repair.without.length > 0 && found;
  return (
    <Card withBorder padding="xs" role="group" aria-label={repair.text}>
      <Group justify="space-between" wrap="nowrap" align="start">
        <div>
          <Text size="sm">{repair.text}</Text>
          {repair.edits
            .filter((edit) => edit !== repair.text)
            .map((edit) => (
              <Text key={edit} size="xs" c="dimmed">
                {edit}
              </Text>
            ))}
        </div>
        {repair.applicable && (
          <MayButton
            operation="apply_repair"
            loading={make.isPending}
            onClick={() => make.mutate()}
            aria-label={`${t("repair.do")}: ${repair.text}`}
          >
            {t("repair.do")}
          </MayButton>
        )}
        {!repair.applicable && canLeaveOut && (
          <Button
            variant="default"
            disabled={rest.length === 0}
            onClick={leaveOut}
            aria-label={`${t("repair.leaveOut")}: ${repair.text}`}
          >
            {t("repair.leaveOut")}
          </Button>
        )}
        {!repair.applicable && !canLeaveOut && (
          <Text size="xs" c="dimmed">
            {t("repair.byHand")}
          </Text>
        )}
      </Group>
    </Card>
  );
}
