import { ActionIcon, Alert, Group, Select, Slider, Text, Tooltip } from "@mantine/core";
import { IconPlayerPause, IconPlayerPlay, IconPlayerSkipBack, IconPlayerSkipForward } from "@tabler/icons-react";
import { type KeyboardEvent, type ReactNode, useState } from "react";
import { useTranslation } from "react-i18next";
import { useReplay } from "../scene3d/replay";
import type { Step } from "./trace";

const SPEEDS = ["0.5", "1", "2", "5", "10"];
const FINEST = 0.1; // s
const KEY_STEPS: Readonly<Record<string, number>> = {
  ArrowRight: 1,
  ArrowUp: 1,
  ArrowLeft: -1,
  ArrowDown: -1,
  PageUp: 10,
  PageDown: -10,
}; // s

/** The time controls of a replay: play, pause, seek, step to step; the 3D view shows that time. */
export function ReplayBar({ steps, choose }: { steps: readonly Step[]; choose: (step: string) => void }) {
  const { t } = useTranslation("task");
  const { replay, time, waits, speed: going, set } = useReplay();
  const [speed, setSpeed] = useState(1);
  if (replay === null) return null;
  const [start, end] = [replay.start, replay.end];
  const play = () => set(going > 0 ? { speed: 0 } : { speed, time: time >= end ? start : time });
  const jump = (step: Step | undefined, otherwise: number) => {
    set({ time: step?.start ?? otherwise });
    if (step !== undefined) choose(step.key);
  };
  const go = (to: number) => set({ time: Math.min(Math.max(to, start), end) });
  // In the capture phase: otherwise the slider handles the arrow and page keys first, with its own step sizes.
  // Space plays and pauses anywhere in the bar, except on controls that use it themselves.
  const keys = (event: KeyboardEvent) => {
    const by = event.target instanceof Element && event.target.role === "slider" ? KEY_STEPS[event.key] : undefined;
    if (by !== undefined) {
      event.preventDefault();
      event.stopPropagation();
      go(time + by);
      return;
    }
    if (event.key !== " " || event.target instanceof HTMLButtonElement || event.target instanceof HTMLInputElement)
      return;
    event.preventDefault();
    play();
  };
  return (
    <div role="group" aria-label={t("replay.label", { job: replay.job })} aria-busy={waits} onKeyDownCapture={keys}>
      <Group gap={4}>
        <Tool
          name={t("replay.before")}
          act={() =>
            jump(
              steps.findLast((one) => one.start < time - 0.3),
              start,
            )
          }
        >
          <IconPlayerSkipBack size={16} />
        </Tool>
        <Tool name={going > 0 ? t("replay.pause") : t("replay.play")} act={play}>
          {going > 0 ? <IconPlayerPause size={16} /> : <IconPlayerPlay size={16} />}
        </Tool>
        <Tool
          name={t("replay.next")}
          act={() =>
            jump(
              steps.find((one) => one.start > time + 0.01),
              end,
            )
          }
        >
          <IconPlayerSkipForward size={16} />
        </Tool>
        <Text size="sm" w={96} ta="right" ml="auto" style={{ fontVariantNumeric: "tabular-nums" }}>
          {`${(time - start).toFixed(1)} / ${(end - start).toFixed(1)} s`}
        </Text>
        <Select
          aria-label={t("replay.speed")}
          w={72}
          data={SPEEDS.map((value) => ({ value, label: `${value}×` }))}
          value={String(going > 0 ? going : speed)}
          onChange={(value) => {
            const chosen = Number(value ?? 1);
            setSpeed(chosen);
            if (going > 0) set({ speed: chosen });
          }}
        />
      </Group>
      <Slider
        mx="xs"
        my={6}
        size="sm"
        min={start}
        max={end}
        step={FINEST}
        value={time}
        label={(value) => `${(value - start).toFixed(1)} s`}
        thumbLabel={t("replay.time")}
        onChange={(value) => set({ time: value })}
      />
      {!replay.complete && (
        <Alert color="yellow" p={4} mt={4}>
          {t("replay.incomplete")}
        </Alert>
      )}
    </div>
  );
}

function Tool({ name, act, children }: { name: string; act: () => void; children: ReactNode }) {
  return (
    <Tooltip label={name}>
      <ActionIcon aria-label={name} onClick={act}>
        {children}
      </ActionIcon>
    </Tooltip>
  );
}
