import { Group, SegmentedControl, Stack, Text } from "@mantine/core";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { ElementPicker } from "../../widgets/ElementPicker";
import classes from "../modules.module.css";
import { Axes, type Vector } from "./Axes";
import { useLive } from "./live";
import { jog } from "./robotJogger";
import { DEGREE, rollPitchYaw, TOOL_SIZES, TURN_SIZES } from "./steps";
import { StepSize } from "./StepSize";

interface Props {
  arm: string;
  disabled: boolean;
}

const FRAMES = ["tool", "base", "map", "element"] as const;
type Frame = (typeof FRAMES)[number];
const NONE: Vector = [0, 0, 0];

/** Jogs the tool of an arm along and about the axes of a frame. */
export function ToolJog({ arm, disabled }: Props) {
  const { t } = useTranslation("modules");
  const [frame, setFrame] = useState<Frame>("tool");
  const [element, setElement] = useState<string | null>(null);
  const [near, setNear] = useState<string | null>(null);
  const [way, setWay] = useState<number>(TOOL_SIZES[2]);
  const [angle, setAngle] = useState<number>(TURN_SIZES[1]);
  const of = frame === "element" ? (element ?? "") : frame;
  const step = (translation: Vector, rotation: Vector) =>
    jog(arm, "jog_tool", { frame: of, translation, rotation, near });
  return (
    <Stack gap="xs">
      <ToolPose arm={arm} />
      <Group gap="xs">
        <Text size="xs">{t("jog.frame")}</Text>
        <SegmentedControl
          size="xs"
          aria-label={t("jog.frame")}
          data={FRAMES.map((name) => ({ value: name, label: t(`jog.frames.${name}`) }))}
          value={frame}
          onChange={(name) => setFrame(name as Frame)}
        />
      </Group>
      {frame === "element" && (
        <ElementPicker
          label={t("jog.frames.element")}
          class_="sk:SpatialThing"
          value={element}
          onChange={setElement}
          required
        />
      )}
      <Group gap="md">
        <StepSize label={t("jog.step")} unit=" mm" sizes={TOOL_SIZES} value={way} onChange={setWay} />
        <StepSize label={t("jog.turnStep")} unit="°" sizes={TURN_SIZES} value={angle} onChange={setAngle} />
      </Group>
      <Axes
        move={(along) => step(times(along, way / 1000), NONE)}
        turn={(about) => step(NONE, times(about, angle * DEGREE))}
        disabled={disabled || of === ""}
      />
      <ElementPicker
        label={t("jog.near")}
        description={t("jog.nearHint")}
        class_="sk:SpatialThing"
        value={near}
        onChange={setNear}
      />
    </Stack>
  );
}

function times([x, y, z]: Vector, size: number): Vector {
  return [x * size, y * size, z * size];
}

/** The pose of the tool in the map. */
function ToolPose({ arm }: { arm: string }) {
  const { t } = useTranslation("modules");
  const text = useLive<HTMLSpanElement>((element, state) => {
    const tool = state.frames[arm];
    element.textContent = tool ? poseText(tool.position, rollPitchYaw(tool.orientation)) : t("jog.unknownTool");
  });
  return (
    <Text size="xs" className={classes.live}>
      {t("jog.toolAt")} <span ref={text} />
    </Text>
  );
}

function poseText(position: readonly number[], angles: readonly number[]): string {
  const metres = position.map((one) => one.toFixed(3)).join(", ");
  const degrees = angles.map((one) => (one / DEGREE).toFixed(1)).join("°, ");
  return `x, y, z = ${metres} m · roll, pitch, yaw = ${degrees}°`;
}
