import { Slider, Text } from "@mantine/core";
import { IconMinus, IconPlus } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import classes from "../modules.module.css";
import type { Device } from "../../api/cell";
import type { Step } from "./jogger";
import { HoldButton } from "./HoldButton";
import { useLive } from "./live";
import { DEGREE } from "./steps";

interface Props {
  robot: string;
  joint: Device["joints"][number];
  /** The part of its name that tells it from the others. */
  short: string;
  /** Position of the slider [rad]; undefined while it follows the joint. */
  target: number | undefined;
  /** The last position of the joint at rest [rad]. */
  rest: number;
  setTarget: (angle: number) => void;
  step: (sign: 1 | -1) => Step;
  disabled: boolean;
}

const EVERYWHERE = Math.PI;

/** One joint: buttons for steps in both directions, its angle between its limits, and a slider for its target. */
export function JointRow({ robot, joint, short, target, rest, setTarget, step, disabled }: Props) {
  const { t } = useTranslation("modules");
  const { name } = joint;
  const [lower, upper] = [joint.lower ?? -EVERYWHERE, joint.upper ?? EVERYWHERE];
  const mark = useLive<HTMLDivElement>((element, state) => {
    const angle = state.joints[`${robot}/${name}`] ?? 0;
    element.style.left = `${(100 * (angle - lower)) / (upper - lower)}%`;
  });
  const degrees = useLive<HTMLSpanElement>((element, state) => {
    element.textContent = inDegrees(state.joints[`${robot}/${name}`] ?? 0);
  });
  return (
    <div className={classes.joint} role="group" aria-label={name}>
      <Text size="xs" truncate title={name}>
        {short}
      </Text>
      <HoldButton step={step(-1)} name={t("jog.minus", { name })} disabled={disabled}>
        <IconMinus size={14} aria-hidden />
      </HoldButton>
      <div className={classes.track}>
        <Slider
          size="sm"
          thumbLabel={t("jog.target", { name })}
          min={lower / DEGREE}
          max={upper / DEGREE}
          step={0.5}
          label={(angle) => `${angle.toFixed(1)}°`}
          value={(target ?? rest) / DEGREE}
          onChange={(angle) => setTarget(angle * DEGREE)}
          disabled={disabled}
        />
        <div className={classes.way} aria-hidden>
          <div ref={mark} className={classes.now} />
        </div>
      </div>
      <HoldButton step={step(1)} name={t("jog.plus", { name })} disabled={disabled}>
        <IconPlus size={14} aria-hidden />
      </HoldButton>
      <Text size="xs" className={classes.live} title={`${inDegrees(lower)} … ${inDegrees(upper)}`}>
        <span ref={degrees} />
        {target !== undefined && ` → ${inDegrees(target)}`}
      </Text>
    </div>
  );
}

function inDegrees(angle: number): string {
  return `${(angle / DEGREE).toFixed(1)}°`;
}
