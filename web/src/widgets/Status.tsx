import { Badge, type MantineColor } from "@mantine/core";
import {
  IconAlertTriangle,
  IconCheck,
  IconCircleDashed,
  IconHandStop,
  IconPlayerPause,
  IconPlayerPlay,
  IconQuestionMark,
  IconX,
  type TablerIcon,
} from "@tabler/icons-react";

/** The mood of a state: icon and text distinguish them, the colour only supports them. */
export type Mood = "waiting" | "running" | "paused" | "asking" | "good" | "bad" | "stopped" | "warning";

const LOOKS: Record<Mood, { icon: TablerIcon; color: MantineColor }> = {
  waiting: { icon: IconCircleDashed, color: "gray" },
  running: { icon: IconPlayerPlay, color: "blue" },
  paused: { icon: IconPlayerPause, color: "grape" },
  asking: { icon: IconQuestionMark, color: "orange" },
  good: { icon: IconCheck, color: "green" },
  bad: { icon: IconX, color: "red" },
  stopped: { icon: IconHandStop, color: "red" },
  warning: { icon: IconAlertTriangle, color: "yellow" },
};

export function Status({ mood, text }: { mood: Mood; text: string }) {
  const { icon: Icon, color } = LOOKS[mood];
  return (
    <Badge variant="light" color={color} leftSection={<Icon size={12} aria-hidden />} tt="none" fw={600}>
      {text}
    </Badge>
  );
}
