import { Fragment } from "react";
import { readRow } from "./goals";
import { RowText } from "./RowText";

interface Props {
  /** Conditions in the server's notation, all required. */
  goal: readonly string[];
  /** Its names are not clickable, since it is part of a clickable element. */
  plain?: boolean;
}

/** The goal as text. */
export function GoalText({ goal, plain = false }: Props) {
  return goal.map((text, index) => (
    <Fragment key={text}>
      {index > 0 && "; "}
      <RowText row={readRow(text)} plain={plain} />
    </Fragment>
  ));
}
