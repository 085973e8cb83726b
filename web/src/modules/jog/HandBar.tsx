import { Button, Group, Text } from "@mantine/core";
import { IconHandStop, IconHome } from "@tabler/icons-react";
import { useEffect } from "react";
import { useTranslation } from "react-i18next";
import { MayButton } from "../../widgets/MayButton";
import { Status } from "../../widgets/Status";
import classes from "../modules.module.css";
import type { Device } from "../../api/cell";
import { HOME } from "./panels";
import { hand, jog } from "./robotHand";

/** What is always in reach while a robot is moved by hand: stop, home, and how the last step went. */
export function HandBar({ devices, disabled }: { devices: readonly Device[]; disabled: boolean }) {
  const { t } = useTranslation("modules");
  useEscape();
  const homed = devices.filter((device) => device.jog.some(({ module }) => module === HOME));
  const home = () => {
    const steps = homed.map(({ id }) => jog(id, HOME));
    hand.all(() => steps.shift() ?? null);
  };
  return (
    <div className={classes.bar} role="region" aria-label={t("jog.bar")}>
      <Group gap="xs">
        <Button
          color="red"
          leftSection={<IconHandStop size={14} aria-hidden />}
          onClick={() => void hand.stop()}
          aria-keyshortcuts="Escape"
        >
          {t("jog.stop")}
        </Button>
        <MayButton
          operation="jog_device"
          variant="default"
          leftSection={<IconHome size={14} aria-hidden />}
          disabled={disabled || homed.length === 0}
          onClick={home}
        >
          {t("jog.home")}
        </MayButton>
        <Verdict />
      </Group>
    </div>
  );
}

function Verdict() {
  const { t } = useTranslation("modules");
  const { moving, said } = hand.useHand();
  return (
    <Group gap="xs" role="status" aria-live="polite" flex="1 1 12rem">
      {moving && <Status mood="running" text={t("jog.moving")} />}
      {said && !moving && <Status mood={said.good ? "good" : "bad"} text={t(said.good ? "jog.done" : "jog.notDone")} />}
      {said && <Text size="xs">{said.text}</Text>}
    </Group>
  );
}

/** Escape stops the hand, too, wherever the focus is; dialogs and lists that it closes are not asked. */
function useEscape(): void {
  useEffect(() => {
    const stop = (event: KeyboardEvent) => {
      if (event.key === "Escape" && hand.useHand.getState().moving) void hand.stop();
    };
    document.addEventListener("keydown", stop, true);
    return () => document.removeEventListener("keydown", stop, true);
  }, []);
}
