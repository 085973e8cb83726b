import { useTranslation } from "react-i18next";
import { ElementName } from "../widgets/ElementName";
import classes from "./goal.module.css";
import { type NewRow, shortText, textOf } from "./goals";
import { useSentence, useWords } from "./words";

interface Props {
  row: NewRow;
  /** Its names are not clickable, since it is part of a clickable element. */
  plain?: boolean;
}

/** A condition in words: a sentence if the present robots know its single word, otherwise as text. */
export function RowText({ row, plain = false }: Props) {
  const { t } = useTranslation("goal");
  const { words } = useWords();
  const sentence = useSentence();
  const word = row.kind === "word" ? words.find(({ name }) => name === row.word) : undefined;
  if (row.kind === "text" || word === undefined) return <code className={classes.code}>{shortText(textOf(row))}</code>;
  return (
    <>
      {row.not && <strong>{t("unwanted")} </strong>}
      {sentence(word).map((piece) =>
        typeof piece === "string" ? piece : <ElementName key={piece} id={row.arguments[piece] ?? ""} plain={plain} />,
      )}
    </>
  );
}
