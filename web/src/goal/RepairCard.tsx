import { Button, Card, Group, Text } from "@mantine/core";
import { Trans, useTranslation } from "react-i18next";
import { answer, api } from "../api/client";
import { useSingleMutation } from "../api/mutations";
import { MayButton } from "../widgets/MayButton";
import { notifyProblem } from "../widgets/problems";
import { notifyChange } from "../widgets/undo";
import { isUntouched, useDraft } from "./draft";
import { type CheckedCondition, type GoalOrder, goalOrder, keyed, repaired, rowOfShort } from "./goals";
import type { Preview } from "./preview";
import { RowText } from "./RowText";
import { ServerText } from "./ServerText";
import { said } from "../i18n/sentences";

type Repair = Preview["repairs"][number];

interface Props {
  preview: string;
  repair: Repair;
  conditions: readonly CheckedCondition[];
  /** The elements and classes that the causes mention. */
  named: readonly string[];
  again: (order?: GoalOrder | null) => void;
}

/** A repair, with a button that applies it. */
export function RepairCard({ preview, repair, conditions, named, again }: Props) {
  return (
    <Card withBorder padding="xs" role="group" aria-label={said(repair.text)}>
      <Group justify="space-between" wrap="nowrap" align="start">
        <Changes repair={repair} conditions={conditions} named={named} />
        <Make preview={preview} repair={repair} conditions={conditions} again={again} />
      </Group>
    </Card>
  );
}

/** Each of its changes. */
function Changes({ repair, conditions, named }: Pick<Props, "repair" | "conditions" | "named">) {
  const { t } = useTranslation("goal");
  const { edits, without, instead, elements, text } = repair;
  const condition = (short: string) => <RowText key={short} row={rowOfShort(short, conditions)} />;
  return (
    <div>
      {instead.map(({ condition: old, by }) => (
        <Text key={by} size="sm">
          <Trans t={t} i18nKey="repair.instead" components={{ by: condition(by), old: condition(old) }} />
        </Text>
      ))}
      {edits.map((edit, index) => (
        <Text key={index} size="sm">
          <ServerText text={edit} named={elements} />
        </Text>
      ))}
      {without.map((short) => (
        <Text key={short} size="sm">
          <Trans t={t} i18nKey="repair.without" components={{ condition: condition(short) }} />
        </Text>
      ))}
      {edits.length + instead.length + without.length === 0 && (
        <Text size="sm">
          <ServerText text={text} named={named} />
        </Text>
      )}
    </div>
  );
}

function Make({ preview, repair, conditions, again }: Omit<Props, "named">) {
  const { t } = useTranslation("goal");
  const { present, setRows } = useDraft();
  const rows = repaired(conditions, repair);
  const want = () => {
    if (rows === null) return;
    if (repair.without.length + repair.instead.length === 0) return again();
    setRows(rows);
    again(goalOrder(keyed(rows)));
  };
  const make = useSingleMutation({
    mutationFn: () =>
      answer(
        api.POST("/api/v1/previews/{id}/repairs/{number}/apply", {
          params: { path: { id: preview, number: repair.id } },
        }),
      ),
    onMutate: present,
    onSuccess: ({ world }, _, pressedAt) => {
      // A change of the goal shows no message: undo applies only to the world.
      notifyChange(t("repair.done", { text: [...new Set(repair.edits)].map(said).join(", ") }), world);
      if (isUntouched(pressedAt, present())) want(); // keeps later edits of the goal
    },
    onError: notifyProblem,
  });
  const onlyLess = repair.edits.length + repair.instead.length === 0;
  const label = t(onlyLess ? "repair.leaveOut" : "repair.do");
  const look = { "aria-label": `${label}: ${said(repair.text)}`, flex: "none" };
  if (repair.applicable && rows !== null)
    return (
      <MayButton operation="apply_repair" loading={make.isPending} onClick={() => make.mutate()} {...look}>
        {label}
      </MayButton>
    );
  if (onlyLess ? repair.without.length === 0 : rows === null)
    return (
      <Text size="xs" c="dimmed">
        {t("repair.byHand")}
      </Text>
    );
  return (
    <Button variant="default" disabled={rows === null || rows.length === 0} onClick={want} {...look}>
      {label}
    </Button>
  );
}
