import { Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { ElementName } from "../widgets/ElementName";
import classes from "./goal.module.css";
import { type CheckedCondition, rowOf, shortText } from "./goals";
import { useSentence, useWords } from "./words";

/** A condition to be read only: as a sentence where it is one word, else as text. */
export function ConditionText({ condition }: { condition: CheckedCondition }) {
  const { t } = useTranslation("goal");
  const { words } = useWords();
  const sentence = useSentence();
  const row = rowOf(condition);
  const word = row.kind === "word" ? words.find(({ name }) => name === row.word) : undefined;
  if (row.kind === "text" || word === undefined) return <pre className={classes.code}>{shortText(condition.text)}</pre>;
  return (
    <Text size="sm">
      {row.not && <strong>{t("unwanted")} </strong>}
      {sentence(word).map((piece) =>
        typeof piece === "string" ? piece : <ElementName key={piece} id={row.arguments[piece] ?? ""} />,
      )}
    </Text>
  );
}
