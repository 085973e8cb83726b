import { Fieldset, Group, Text } from "@mantine/core";
import { type ReactNode, useState } from "react";
import { useTranslation } from "react-i18next";
import { numbersOf, type PoseNumbers, poseFrom } from "../../scene3d/pose";
import { NumberField } from "../../widgets/arguments/NumberField";
import { intoView } from "../../widgets/intoView";
import { ElementPicker } from "../../widgets/ElementPicker";
import type { PoseValue } from "../values";

interface Props {
  label: string;
  description?: string;
  error?: ReactNode;
  value: PoseValue;
  onChange: (value: PoseValue) => void;
  /** Whether the frame can be chosen; otherwise the property determines it. */
  framed: boolean;
}

const LENGTHS = ["x", "y", "z"] as const;
const ANGLES = ["roll", "pitch", "yaw"] as const;

/** A pose being edited; missing numbers are undefined or NaN. */
type Written = Record<keyof PoseNumbers, number | undefined>;

/** Edits a pose in metres and degrees; incomplete poses contain NaN and cannot be saved. */
export function PoseInput({ label, description, error, value, onChange, framed }: Props) {
  const { t } = useTranslation("world");
  // Angles are kept as typed: a quaternion does not determine them uniquely.
  const [numbers, setNumbers] = useState<Written>(() => numbersOf(value));
  const take = (change: Partial<Written>) => {
    const next = { ...numbers, ...change };
    setNumbers(next);
    onChange({ ...value, ...poseFrom(complete(next)) });
  };
  return (
    <Fieldset legend={label} p="xs">
      {description && (
        <Text size="xs" c="dimmed">
          {description}
        </Text>
      )}
      <Numbers names={LENGTHS} label={label} numbers={numbers} unit="m" step={0.01} onChange={take} />
      <Numbers names={ANGLES} label={label} numbers={numbers} unit="°" step={5} onChange={take} />
      {framed && (
        <ElementPicker
          label={t("value.frame")}
          class_="sk:SpatialThing"
          value={value.frame ?? null}
          onChange={(frame) => onChange({ ...value, frame })}
          description={t("value.frameHelp")}
        />
      )}
      {error && (
        <Text ref={intoView} size="xs" c="red" role="alert" style={{ scrollMarginBottom: 70 }}>
          {error}
        </Text>
      )}
    </Fieldset>
  );
}

function complete(written: Written): PoseNumbers {
  const { x = NaN, y = NaN, z = NaN, roll = NaN, pitch = NaN, yaw = NaN } = written;
  return { x, y, z, roll, pitch, yaw };
}

interface NumbersProps {
  names: readonly (keyof PoseNumbers)[];
  label: string;
  numbers: Written;
  unit: string;
  step: number;
  onChange: (change: Partial<Written>) => void;
}

function Numbers({ names, label, numbers, unit, step, onChange }: NumbersProps) {
  const { t } = useTranslation("world");
  return (
    <Group gap={6} grow wrap="nowrap">
      {names.map((name) => (
        <NumberField
          key={name}
          label={t(`value.${name}`)}
          aria-label={`${label}: ${t(`value.${name}`)}`}
          unit={unit}
          step={step}
          value={numbers[name]}
          onChange={(number) => onChange({ [name]: number })}
        />
      ))}
    </Group>
  );
}
