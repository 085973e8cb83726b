import { Group, SimpleGrid, Stack, Text } from "@mantine/core";
import {
  IconArrowDown,
  IconArrowLeft,
  IconArrowRight,
  IconArrowUp,
  IconRotate2,
  IconRotateClockwise2,
} from "@tabler/icons-react";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import classes from "../modules.module.css";
import { HoldButton } from "./HoldButton";
import { useLive } from "./live";
import { jog } from "./robotJogger";
import { BASE_SIZES, DEGREE, rollPitchYaw, TURN_SIZES } from "./steps";
import { StepSize } from "./StepSize";

interface Props {
  base: string;
  disabled: boolean;
}

/** Motions as (dx, dy, dyaw), in the order of the buttons. */
const WAYS = [
  { name: "turnLeft", icon: IconRotate2, way: [0, 0, 1] },
  { name: "ahead", icon: IconArrowUp, way: [1, 0, 0] },
  { name: "turnRight", icon: IconRotateClockwise2, way: [0, 0, -1] },
  { name: "left", icon: IconArrowLeft, way: [0, 1, 0] },
  { name: "back", icon: IconArrowDown, way: [-1, 0, 0] },
  { name: "right", icon: IconArrowRight, way: [0, -1, 0] },
] as const;

export function BaseJog({ base, disabled }: Props) {
  const { t } = useTranslation("modules");
  const [size, setSize] = useState<number>(BASE_SIZES[1]);
  const [angle, setAngle] = useState<number>(TURN_SIZES[1]);
  const step = ([x, y, yaw]: readonly [number, number, number]) =>
    jog(base, "jog_base", { dx: (x * size) / 1000, dy: (y * size) / 1000, dyaw: yaw * angle * DEGREE });
  return (
    <Stack gap="xs">
      <BasePose base={base} />
      <Group gap="md">
        <StepSize label={t("jog.step")} unit=" mm" sizes={BASE_SIZES} value={size} onChange={setSize} />
        <StepSize label={t("jog.turnStep")} unit="°" sizes={TURN_SIZES} value={angle} onChange={setAngle} />
      </Group>
      <SimpleGrid cols={3} spacing={4} maw="24rem">
        {WAYS.map(({ name, icon: Icon, way }) => (
          <HoldButton
            key={name}
            step={step(way)}
            name={t(`jog.ways.${name}`)}
            disabled={disabled}
            leftSection={<Icon size={14} aria-hidden />}
          >
            {t(`jog.ways.${name}`)}
          </HoldButton>
        ))}
      </SimpleGrid>
      <Text size="xs" c="dimmed">
        {t("jog.baseHint")}
      </Text>
    </Stack>
  );
}

function BasePose({ base }: { base: string }) {
  const { t } = useTranslation("modules");
  const text = useLive<HTMLSpanElement>((element, state) => {
    const pose = state.platforms[base];
    if (pose === undefined) return;
    const [x, y] = pose.position;
    const yaw = rollPitchYaw(pose.orientation)[2] / DEGREE;
    element.textContent = `x, y = ${x.toFixed(3)}, ${y.toFixed(3)} m · ${yaw.toFixed(1)}°`;
  });
  return (
    <Text size="xs" className={classes.live}>
      {t("jog.baseAt")} <span ref={text} />
    </Text>
  );
}
