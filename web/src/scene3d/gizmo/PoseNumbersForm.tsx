import { SimpleGrid } from "@mantine/core";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { NumberField } from "../../widgets/arguments/NumberField";
import { inMap, numbersOf, poseFrom, type PoseNumbers, seenFrom } from "../pose";
import type { MapPose } from "../tools";
import { poseInMap } from "./useMovable";

const FIELDS = ["x", "y", "z", "roll", "pitch", "yaw"] as const;
type Field = keyof PoseNumbers;

interface Props {
  /** Pose in the map. */
  pose: MapPose;
  /** Element in whose frame the numbers are; null for the map. */
  frame: string | null;
  onChange: (pose: MapPose) => void;
  /** Called with whether all fields contain numbers; otherwise the pose is unchanged. */
  onSound: (sound: boolean) => void;
}

/** A pose as numbers: metres, and degrees about the fixed axes. */
export function PoseNumbersForm({ pose, frame, onChange, onSound }: Props) {
  const { t } = useTranslation("scene3d");
  const [typed, setTyped] = useState<{ field: Field; number: number | undefined } | null>(null);
  const base = frame === null ? null : poseInMap(frame);
  const numbers = numbersOf(seenFrom(pose, base));
  const change = (field: Field, number: number | undefined) => {
    const sound = number !== undefined && !Number.isNaN(number);
    setTyped({ field, number });
    onSound(sound);
    if (sound) onChange(inMap(poseFrom({ ...numbers, [field]: number }), base));
  };
  const leave = () => {
    setTyped(null);
    onSound(true);
  };
  return (
    <SimpleGrid cols={3} spacing={6} verticalSpacing={4}>
      {FIELDS.map((field) => (
        <NumberField
          key={field}
          label={t(`pose.${field}`)}
          value={typed?.field === field ? typed.number : numbers[field]}
          onChange={(value) => change(field, value)}
          onBlur={leave}
          step={isAngle(field) ? 5 : 0.01}
          unit={isAngle(field) ? "°" : "m"}
        />
      ))}
    </SimpleGrid>
  );
}

function isAngle(field: Field): boolean {
  return field === "roll" || field === "pitch" || field === "yaw";
}
