import { ActionIcon, Group, Select, Tooltip } from "@mantine/core";
import { IconArrowsMove, IconRotate } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { type GizmoMode, useTools } from "../tools";

const MODES: Record<GizmoMode, typeof IconRotate> = { translate: IconArrowsMove, rotate: IconRotate };

interface Props {
  /** Place of the element, whose frame the numbers may use. */
  place: string | null;
  frame: string | null;
  setFrame: (id: string | null) => void;
}

/** Settings of the handles: translate or rotate, step size, and the frame of the numbers. */
export function PoseModes({ place, frame, setFrame }: Props) {
  const { t } = useTranslation("scene3d");
  const { mode, snap, set } = useTools();
  const frames = [{ value: "", label: t("pose.map") }, ...(place === null ? [] : [{ value: place, label: place }])];
  return (
    <Group gap={4} mb={6} align="end" wrap="nowrap">
      {Object.entries(MODES).map(([name, Icon]) => (
        <Tooltip key={name} label={t(`pose.${name as GizmoMode}`)}>
          <ActionIcon
            variant={mode === name ? "filled" : "default"}
            aria-label={t(`pose.${name as GizmoMode}`)}
            aria-pressed={mode === name}
            onClick={() => set({ mode: name as GizmoMode })}
          >
            <Icon size={16} />
          </ActionIcon>
        </Tooltip>
      ))}
      <Select
        aria-label={t("pose.snap")}
        data={SNAPS.map(({ value, label }) => ({ value, label: label || t("pose.free") }))}
        value={String(snap.translate)}
        allowDeselect={false}
        w={92}
        onChange={(value) => set({ snap: SNAPS.find((one) => one.value === value)?.snap ?? snap })}
      />
      <Select
        aria-label={t("pose.frame")}
        data={frames}
        value={frame ?? ""}
        allowDeselect={false}
        flex={1}
        onChange={(value) => setFrame(value || null)}
      />
    </Group>
  );
}

const SNAPS = [
  [0, 0, ""],
  [0.001, 1, "1 mm, 1°"],
  [0.01, 5, "1 cm, 5°"],
  [0.1, 15, "10 cm, 15°"],
].map(([length, degrees, label]) => ({
  value: String(length),
  label: String(label),
  snap: { translate: Number(length), rotate: (Number(degrees) * Math.PI) / 180 },
}));
