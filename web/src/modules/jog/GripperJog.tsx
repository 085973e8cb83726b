import { Button, Group, Stack, Text } from "@mantine/core";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { NumberField } from "../../widgets/arguments/NumberField";
import classes from "../modules.module.css";
import { useLive } from "./live";
import { jogger, jog } from "./robotJogger";

interface Props {
  gripper: string;
  /** Maximum distance between the fingers [m]. */
  maxGap: number;
  disabled: boolean;
}

/** The fingers: open, close on an object, or move to a distance. */
export function GripperJog({ gripper, maxGap, disabled }: Props) {
  const { t } = useTranslation("modules");
  const [wanted, setWanted] = useState<number>();
  const most = maxGap * 1000; // mm
  const move = (millimetres: number) => jogger.once(jog(gripper, "gripper_control", { gap: millimetres / 1000 }));
  const sound = wanted !== undefined && wanted >= 0 && wanted <= most; // false for NaN
  return (
    <Stack gap="xs">
      <Fingers gripper={gripper} />
      <Group gap="xs" align="end">
        <Button variant="default" disabled={disabled} onClick={() => move(most)}>
          {t("jog.open")}
        </Button>
        <Button variant="default" disabled={disabled} onClick={() => move(0)}>
          {t("jog.close")}
        </Button>
        <NumberField
          label={t("jog.width", { most: Math.round(most) })}
          w="10rem"
          min={0}
          max={most}
          error={wanted !== undefined && !sound}
          value={wanted}
          onChange={setWanted}
        />
        <Button variant="default" disabled={disabled || !sound} onClick={() => sound && move(wanted)}>
          {t("jog.moveFingers")}
        </Button>
      </Group>
    </Stack>
  );
}

function Fingers({ gripper }: { gripper: string }) {
  const { t } = useTranslation("modules");
  const text = useLive<HTMLSpanElement>((element, state) => {
    const { state: now, holds } = state.devices[gripper] ?? {};
    if (!now) return;
    const gap = t("jog.gap", { gap: (Number(now["gap"]) * 1000).toFixed(1), force: Number(now["force"]).toFixed(0) });
    element.textContent = holds ? `${gap} · ${t("jog.holds", { what: holds })}` : gap;
  });
  return (
    <Text size="xs" className={classes.live}>
      <span ref={text} />
    </Text>
  );
}
