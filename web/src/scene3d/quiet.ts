/** Suppresses a useless warning: react-three-fiber uses a clock that three.js deprecates. */

import { setConsoleFunction } from "three";

setConsoleFunction((kind, message, ...more) => {
  if (message.startsWith("THREE.Clock:")) return;
  console[kind](message, ...more); // eslint-disable-line no-console -- it is three that speaks
});
