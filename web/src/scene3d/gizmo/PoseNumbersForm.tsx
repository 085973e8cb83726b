import { NumberInput, SimpleGrid } from "@mantine/core";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { inMap, numbersOf, poseFrom, type PoseNumbers, seenFrom } from "../pose";
import type { MapPose } from "../tools";
import { poseInMap } from "./useMovable";

const FIELDS = ["x", "y", "z", "roll", "pitch", "yaw"] as const;
type Field = keyof PoseNumbers;

interface Props {
  /** In the map. */
  pose: MapPose;
  /** Element in whose frame the numbers are; null for the map. */
  frame: string | null;
  onChange: (pose: MapPose) => void;
}

/** A pose in numbers: metres, and degrees about the fixed axes. */
export function PoseNumbersForm({ pose, frame, onChange }: Props) {
  const { t } = useTranslation("scene3d");
  const [typed, setTyped] = useState<{ field: Field; text: number | string } | null>(null);
  const base = frame === null ? null : poseInMap(frame);
  const numbers = numbersOf(seenFrom(pose, base));
  const change = (field: Field, text: number | string) => {
    setTyped({ field, text });
    if (typeof text === "number") onChange(inMap(poseFrom({ ...numbers, [field]: text }), base));
  };
  return (
    <SimpleGrid cols={3} spacing={6} verticalSpacing={4}>
      {FIELDS.map((field) => (
        <NumberInput
          key={field}
          label={t(`pose.${field}`)}
          value={typed?.field === field ? typed.text : numbers[field]}
          onChange={(value) => change(field, value)}
          onBlur={() => setTyped(null)}
          step={isAngle(field) ? 5 : 0.01}
          decimalScale={isAngle(field) ? 2 : 4}
          suffix={isAngle(field) ? "°" : " m"}
          hideControls
        />
      ))}
    </SimpleGrid>
  );
}

function isAngle(field: Field): boolean {
  return field === "roll" || field === "pitch" || field === "yaw";
}
