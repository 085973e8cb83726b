import { Fragment } from "react";
import { readRow } from "./goals";
import { RowText } from "./RowText";

interface Props {
  /** Conditions as the server writes them, all of which are wanted. */
  goal: readonly string[];
  /** Its names cannot be clicked: it stands within something that can be. */
  plain?: boolean;
}

/** What is wanted, in words. */
export function GoalText({ goal, plain = false }: Props) {
  return goal.map((text, index) => (
    <Fragment key={text}>
      {index > 0 && "; "}
      <RowText row={readRow(text)} plain={plain} />
    </Fragment>
  ));
}
