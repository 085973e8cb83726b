import { useTranslation } from "react-i18next";
import { useStation } from "../../live/station";
import type { RobotInfo as Robot } from "../../api/cell";
import { hindranceOf } from "./hindrance";
import { jogger } from "./robotJogger";
import { said } from "../../i18n/sentences";

/** Returns the text that tells why a robot cannot be jogged; empty if it can. */
export function useHindrance(robot: Robot, alone: boolean): string {
  const { t } = useTranslation("modules");
  const own = jogger.useState(({ moving }) => moving);
  return useStation(({ state }) => {
    const hindrance = hindranceOf(state, robot, own, alone);
    switch (hindrance?.why) {
      case undefined:
        return "";
      case "unknown":
        return t("jog.hindrance.unknown");
      case "halted":
        return t("jog.hindrance.halted", { why: said(hindrance.text) });
      case "atWork":
      case "paused":
        return t(`jog.hindrance.${hindrance.why}`, { modules: hindrance.modules.join(", ") });
      case "task":
        return t("jog.hindrance.task", { tasks: hindrance.tasks.join(", ") });
    }
  });
}
