import { Group, SegmentedControl, Text } from "@mantine/core";

interface Props {
  label: string;
  unit: string;
  sizes: readonly number[];
  value: number;
  onChange: (size: number) => void;
}

export function StepSize({ label, unit, sizes, value, onChange }: Props) {
  return (
    <Group gap={6}>
      <Text size="xs">{label}</Text>
      <SegmentedControl
        size="xs"
        aria-label={label}
        data={sizes.map((size) => ({ value: String(size), label: `${size}${unit}` }))}
        value={String(value)}
        onChange={(size) => onChange(Number(size))}
      />
    </Group>
  );
}
