import { Fieldset, Group, NumberInput, Text } from "@mantine/core";
import { type ReactNode, useState } from "react";
import { useTranslation } from "react-i18next";
import { ElementPicker } from "../../widgets/ElementPicker";
import { anglesOf, orientationOf, type PoseValue } from "../values";

interface Props {
  label: string;
  description?: string;
  error?: ReactNode;
  value: PoseValue;
  onChange: (value: PoseValue) => void;
  /** Whether the frame may be chosen; else the property says in which one it is. */
  framed: boolean;
}

const AXES = ["x", "y", "z"] as const;
const ANGLES = ["roll", "pitch", "yaw"] as const;

/** Takes a pose in metres and degrees. */
export function PoseInput({ label, description, error, value, onChange, framed }: Props) {
  const { t } = useTranslation("world");
  // Kept as they are typed: a quaternion does not tell which of several angles was meant.
  const [angles, setAngles] = useState(() => anglesOf(value.orientation));
  const turn = (index: number, degrees: number) => {
    const next = angles.with(index, degrees) as typeof angles;
    setAngles(next);
    onChange({ ...value, orientation: orientationOf(next) });
  };
  const shift = (index: number, metres: number) =>
    onChange({ ...value, position: value.position.with(index, metres) as PoseValue["position"] });
  return (
    <Fieldset legend={label} p="xs">
      {description && (
        <Text size="xs" c="dimmed">
          {description}
        </Text>
      )}
      <Numbers names={AXES} label={label} values={value.position} unit="m" step={0.01} onChange={shift} />
      <Numbers names={ANGLES} label={label} values={angles} unit="°" step={5} onChange={turn} />
      {framed && (
        <ElementPicker
          label={t("value.frame")}
          class_="sk:SpatialThing"
          value={value.frame ?? null}
          onChange={(frame) => onChange({ ...value, frame })}
        />
      )}
      {error && (
        <Text size="xs" c="red" role="alert">
          {error}
        </Text>
      )}
    </Fieldset>
  );
}

interface NumbersProps {
  names: typeof AXES | typeof ANGLES;
  label: string;
  values: readonly number[];
  unit: string;
  step: number;
  onChange: (index: number, value: number) => void;
}

function Numbers({ names, label, values, unit, step, onChange }: NumbersProps) {
  const { t } = useTranslation("world");
  return (
    <Group gap={6} grow wrap="nowrap">
      {names.map((name, index) => (
        <NumberInput
          key={name}
          label={t(`value.${name}`)}
          aria-label={`${label}: ${t(`value.${name}`)}`}
          suffix={` ${unit}`}
          step={step}
          decimalScale={4}
          hideControls
          value={values[index]}
          onChange={(value) => typeof value === "number" && onChange(index, value)}
        />
      ))}
    </Group>
  );
}
