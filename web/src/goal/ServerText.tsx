import { Fragment } from "react";
import { useTranslation } from "react-i18next";
import { said } from "../i18n/sentences";
import { useLiveView } from "../scene3d/view";
import { ElementName } from "../widgets/ElementName";
import { useClassLabels } from "../widgets/names";
import { namedIn } from "./causes";
import { readRow } from "./goals";
import { RowText } from "./RowText";
import { useWords } from "./words";

interface Props {
  text: string;
  /** Names that the text may mention: classes, and elements that are not visible anywhere. */
  named?: readonly string[];
  /** Its names are not clickable, since it is part of a clickable element. */
  plain?: boolean;
}

const NONE: readonly string[] = [];
const CAMEL = /\b[a-z]+(?:[A-Z][a-z]+|A)+\b/g; // names of relations and properties: heldBy, hasA

/** A sentence by the server in the language of the pages: elements and classes as clickable labels, conditions and relations in words. */
export function ServerText({ text, named = NONE, plain = false }: Props) {
  const { t } = useTranslation();
  const terms: Record<string, string> = t("terms", { returnObjects: true });
  const { words } = useWords();
  const classes = useClassLabels();
  const elements = useLiveView(({ view }) => view?.elements);
  const inWords = (rest: string) =>
    rest.replaceAll(CAMEL, (term) => terms[term] ?? term).replace(/\bnot $/, `${t("not")} `);
  const isElement = (word: string) => elements?.has(word) ?? false;
  const isCondition = (word: string) => words.some(({ name }) => name === word);
  return namedIn(said(text), named, isElement, isCondition).map((piece, index) => {
    if ("text" in piece) return <Fragment key={index}>{inWords(piece.text)}</Fragment>;
    if ("condition" in piece) return <RowText key={index} row={readRow(piece.condition)} plain={plain} />;
    const class_ = classes.get(piece.name);
    return class_ === undefined ? (
      <ElementName key={index} id={piece.name} plain={plain} />
    ) : (
      <em key={index}>{class_}</em>
    );
  });
}
