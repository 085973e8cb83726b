/** One warning is of no use to anybody here: fiber makes a clock of its own, of a kind that three would replace. */

import { setConsoleFunction } from "three";

setConsoleFunction((kind, message, ...more) => {
  if (message.startsWith("THREE.Clock:")) return;
  if (kind === "error") console.error(message, ...more);
  else console.warn(message, ...more);
});
