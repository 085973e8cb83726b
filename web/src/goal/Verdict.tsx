import { Text } from "@mantine/core";
import { IconAlertTriangle, IconCheck, IconCircleDashed, IconPencil, type TablerIcon } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import type { Verdict as Check } from "./checks";
import classes from "./goal.module.css";
import { namesIn } from "./goals";
import { ServerText } from "./ServerText";

const LOOKS: Record<Check["state"], { icon: TablerIcon; color: string }> = {
  incomplete: { icon: IconPencil, color: "dimmed" },
  asking: { icon: IconCircleDashed, color: "dimmed" },
  holds: { icon: IconCheck, color: "var(--mantine-color-green-text)" },
  open: { icon: IconCircleDashed, color: "var(--mantine-color-blue-text)" },
  wrong: { icon: IconAlertTriangle, color: "var(--mantine-color-red-text)" },
};

/** Whether a condition already holds, and the reason. */
export function Verdict({ verdict: { state, why, conditions } }: { verdict: Check }) {
  const { t } = useTranslation("goal");
  const { icon: Icon, color } = LOOKS[state];
  const named = conditions.flatMap(namesIn);
  return (
    <Text size="xs" c={color} className={classes.verdict} component="div">
      <Icon size={14} aria-hidden className={classes.icon} />
      <span>
        <strong>{t(`verdict.${state}`)}</strong>
        {why && (
          <span className={classes.why}>
            : <ServerText text={why} named={named} />
          </span>
        )}
      </span>
    </Text>
  );
}
