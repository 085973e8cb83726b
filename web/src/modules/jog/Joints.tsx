import { Button, Group, Stack, Text } from "@mantine/core";
import { IconArrowBackUp, IconPlayerTrackNext } from "@tabler/icons-react";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { useStation } from "../../live/station";
import type { Robot } from "../queries";
import { told } from "./hand";
import { JointRow } from "./JointRow";
import { useRest } from "./live";
import { hand, jog } from "./robotHand";
import { DEGREE, JOINT_SIZES, stepsTo } from "./steps";
import { StepSize } from "./StepSize";

interface Props {
  robot: string;
  arm: Robot["arms"][number];
  disabled: boolean;
}

/** The joints of an arm: each by steps, or all together to where the sliders were put. */
export function Joints({ robot, arm, disabled }: Props) {
  const { t } = useTranslation("modules");
  const [size, setSize] = useState<number>(JOINT_SIZES[1]);
  const [targets, setTargets] = useState<Readonly<Record<number, number>>>({});
  const rest = useRest(arm.id);
  const turn = (deltas: number[]) => jog(robot, { joints: { arm: arm.id, deltas } });
  const turnOne = (joint: number, degrees: number) =>
    told(
      turn(arm.joints.map((_, at) => (at === joint ? degrees * DEGREE : 0))),
      t("jog.turned", { joint: arm.joints[joint]?.name, degrees }),
    );
  const go = () => {
    const now = useStation.getState().state?.arms[arm.id]?.positions ?? [];
    const steps = stepsTo(
      now,
      arm.joints.map((_, joint) => targets[joint] ?? now[joint] ?? 0),
    );
    hand.all(() => {
      const [next] = steps.splice(0, 1);
      return next === undefined ? null : told(turn(next), t("jog.turnedAll"));
    });
    setTargets({});
  };
  const chosen = Object.keys(targets).length;
  return (
    <Stack gap={4}>
      <StepSize label={t("jog.step")} unit="°" sizes={JOINT_SIZES} value={size} onChange={setSize} />
      {arm.joints.map((joint, index) => (
        <JointRow
          key={joint.name}
          arm={arm.id}
          index={index}
          joint={joint}
          target={targets[index]}
          rest={rest[index] ?? 0}
          setTarget={(angle) => setTargets({ ...targets, [index]: angle })}
          step={(sign) => turnOne(index, sign * size)}
          disabled={disabled}
        />
      ))}
      <Group gap="xs" mt={4}>
        <Button
          leftSection={<IconPlayerTrackNext size={14} aria-hidden />}
          disabled={disabled || chosen === 0}
          onClick={go}
        >
          {t("jog.go")}
        </Button>
        <Button
          variant="default"
          leftSection={<IconArrowBackUp size={14} aria-hidden />}
          disabled={chosen === 0}
          onClick={() => setTargets({})}
        >
          {t("jog.forgetTargets")}
        </Button>
        <Text size="xs" c="dimmed">
          {t("jog.sliderHint")}
        </Text>
      </Group>
    </Stack>
  );
}
