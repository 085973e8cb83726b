import { List, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { causeOf } from "./causes";
import { type CheckedCondition, rowOfShort } from "./goals";
import type { Preview } from "./preview";
import { RowText } from "./RowText";
import { ServerText } from "./ServerText";
import { said } from "../i18n/sentences";

interface Props {
  cause: Preview["causes"][number];
  /** The conditions of the goal. */
  conditions: readonly CheckedCondition[];
}

/** One cause: its kind, the conditions it affects, and its explanation. */
export function Reason({ cause: data, conditions }: Props) {
  const { t } = useTranslation("goal");
  const cause = causeOf(data);
  const heading = cause.kind && t(`cause.${cause.kind}`, { count: cause.conditions.length });
  return (
    <div>
      {heading && (
        <Text size="sm" fw={600}>
          {heading}
        </Text>
      )}
      <List size="sm" aria-label={t("cause.conditions")}>
        {cause.conditions.map((text) => (
          <List.Item key={text}>
            <RowText row={rowOfShort(text, conditions)} />
          </List.Item>
        ))}
      </List>
      {cause.why && (
        <Text size="sm">
          <ServerText text={cause.why} named={cause.named} />
        </Text>
      )}
      {!cause.text.endsWith(`: ${cause.why}`) && cause.text !== cause.why && cause.why !== "" && (
        <details>
          <Text component="summary" size="xs">
            {t("cause.whole")}
          </Text>
          <Text size="xs">{said(cause.text)}</Text>
        </details>
      )}
    </div>
  );
}
