/** One warning is of no use to anybody here: fiber makes a clock of its own, of a kind that three would replace. */

import { setConsoleFunction } from "three";

setConsoleFunction((kind, message, ...more) => {
  if (message.startsWith("THREE.Clock:")) return;
  console[kind](message, ...more); // eslint-disable-line no-console -- it is three that speaks
});
