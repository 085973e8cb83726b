import { Fragment } from "react";
import { useLiveView } from "../scene3d/view";
import { ElementName } from "../widgets/ElementName";
import { useClassLabels } from "../widgets/names";
import { namedIn } from "./causes";

interface Props {
  text: string;
  /** Names that the text may mention: classes, and elements that are not visible anywhere. */
  named?: readonly string[];
}

const NONE: readonly string[] = [];

/** A sentence by the server, with elements and classes replaced by clickable labels. */
export function ServerText({ text, named = NONE }: Props) {
  const classes = useClassLabels();
  const elements = useLiveView(({ view }) => view?.elements);
  return namedIn(text, named, (word) => elements?.has(word) ?? false).map((piece, index) => {
    if ("text" in piece) return <Fragment key={index}>{piece.text}</Fragment>;
    const class_ = classes.get(piece.name);
    return class_ === undefined ? <ElementName key={index} id={piece.name} /> : <em key={index}>{class_}</em>;
  });
}
