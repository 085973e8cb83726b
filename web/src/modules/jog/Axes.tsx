import { Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { Fragment } from "react";
import classes from "../modules.module.css";
import type { Step } from "./jogger";
import { HoldButton } from "./HoldButton";

export type Vector = [number, number, number];

const AXES = ["x", "y", "z"] as const;

interface Props {
  /** Translates along an axis, by one step times the vector. */
  move: (along: Vector) => Step;
  /** Rotates about an axis. */
  turn: (about: Vector) => Step;
  disabled: boolean;
}

/** Buttons for translation along and rotation about each axis of a frame. */
export function Axes({ move, turn, disabled }: Props) {
  const { t } = useTranslation("modules");
  return (
    <div className={classes.axes}>
      {AXES.map((axis, index) => (
        <Fragment key={axis}>
          <Text size="xs">{axis}</Text>
          {([-1, 1] as const).map((sign) => (
            <HoldButton
              key={sign}
              step={move(unit(index, sign))}
              name={t("jog.move", { axis: `${sign < 0 ? "−" : "+"}${axis}` })}
              disabled={disabled}
            >
              {sign < 0 ? "−" : "+"}
              {axis}
            </HoldButton>
          ))}
          <Text size="xs">{t("jog.about", { axis })}</Text>
          {([-1, 1] as const).map((sign) => (
            <HoldButton
              key={sign}
              step={turn(unit(index, sign))}
              name={t("jog.turn", { axis: `${sign < 0 ? "−" : "+"}${axis}` })}
              disabled={disabled}
            >
              {sign < 0 ? "↻" : "↺"} {axis}
            </HoldButton>
          ))}
        </Fragment>
      ))}
    </div>
  );
}

function unit(axis: number, sign: number): Vector {
  return [axis === 0 ? sign : 0, axis === 1 ? sign : 0, axis === 2 ? sign : 0];
}
