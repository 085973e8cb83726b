import { Text } from "@mantine/core";
import { type CheckedCondition, rowOf } from "./goals";
import { RowText } from "./RowText";

/** A condition, read-only. */
export function ConditionText({ condition }: { condition: CheckedCondition }) {
  return (
    <Text size="sm">
      <RowText row={rowOf(condition)} />
    </Text>
  );
}
