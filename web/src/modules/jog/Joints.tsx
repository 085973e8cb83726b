import { Button, Group, Stack, Text } from "@mantine/core";
import { IconArrowBackUp, IconPlayerTrackNext } from "@tabler/icons-react";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { useStation } from "../../live/station";
import type { Device } from "../../api/cell";
import { withDoneText } from "./jogger";
import { JointRow } from "./JointRow";
import { useRest } from "./live";
import { jogger, jog } from "./robotJogger";
import { DEGREE, JOINT_SIZES, stepsTo } from "./steps";
import { StepSize } from "./StepSize";
import { withoutCommon } from "../../widgets/names";

interface Props {
  device: Device;
  robot: string;
  disabled: boolean;
}

/** The joints of a device: moved by steps, or together to the targets set with the sliders. */
export function Joints({ device: { id, joints }, robot, disabled }: Props) {
  const { t } = useTranslation("modules");
  const [size, setSize] = useState<number>(JOINT_SIZES[1]);
  const [targets, setTargets] = useState<Readonly<Record<number, number>>>({});
  const names = joints.map(({ name }) => `${robot}/${name}`);
  const short = withoutCommon(joints.map(({ name }) => name));
  const rest = useRest(names);
  const turn = (deltas: number[]) => jog(id, "jog_joints", { deltas });
  const turnOne = (joint: number, degrees: number) =>
    withDoneText(
      turn(names.map((_, at) => (at === joint ? degrees * DEGREE : 0))),
      t("jog.turned", { joint: joints[joint]?.name, degrees }),
    );
  const go = () => {
    const all = useStation.getState().state?.joints ?? {};
    const now = names.map((name) => all[name] ?? 0);
    const steps = stepsTo(
      now,
      now.map((angle, joint) => targets[joint] ?? angle),
    );
    jogger.all(() => {
      const [next] = steps.splice(0, 1);
      return next === undefined ? null : withDoneText(turn(next), t("jog.turnedAll"));
    });
    setTargets({});
  };
  const chosen = Object.keys(targets).length;
  return (
    <Stack gap={4}>
      <StepSize label={t("jog.step")} unit="°" sizes={JOINT_SIZES} value={size} onChange={setSize} />
      {joints.map((joint, index) => (
        <JointRow
          key={joint.name}
          robot={robot}
          joint={joint}
          short={short[index] ?? joint.name}
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
