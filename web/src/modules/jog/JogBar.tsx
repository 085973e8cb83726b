import { Button, Group, Text } from "@mantine/core";
import { IconHandStop, IconHome } from "@tabler/icons-react";
import { useEffect } from "react";
import { useTranslation } from "react-i18next";
import { MayButton } from "../../widgets/MayButton";
import { Status } from "../../widgets/Status";
import classes from "../modules.module.css";
import type { Device } from "../../api/cell";
import { HOME } from "./panels";
import { jogger, jog } from "./robotJogger";
import { said } from "../../i18n/sentences";

/** Stop, home and the result of the last step: always visible while a robot is jogged. */
export function JogBar({ devices, disabled }: { devices: readonly Device[]; disabled: boolean }) {
  const { t } = useTranslation("modules");
  useEscape();
  const homed = devices.filter((device) => device.jog.some(({ module }) => module === HOME));
  const home = () => {
    const steps = homed.map(({ id }) => jog(id, HOME));
    jogger.all(() => steps.shift() ?? null);
  };
  return (
    <div className={classes.bar} role="region" aria-label={t("jog.bar")}>
      <Group gap="xs">
        <Button
          color="red"
          leftSection={<IconHandStop size={14} aria-hidden />}
          onClick={() => void jogger.stop()}
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
  const { moving, result } = jogger.useState();
  return (
    <Group gap="xs" role="status" aria-live="polite" flex="1 1 12rem">
      {moving && <Status mood="running" text={t("jog.moving")} />}
      {result && !moving && (
        <Status mood={result.succeeded ? "good" : "bad"} text={t(result.succeeded ? "jog.done" : "jog.notDone")} />
      )}
      {result && <Text size="xs">{said(result.text)}</Text>}
    </Group>
  );
}

/** Escape stops jogging wherever the focus is, even if it also closes a dialog or a list. */
function useEscape(): void {
  useEffect(() => {
    const stop = (event: KeyboardEvent) => {
      if (event.key === "Escape" && jogger.useState.getState().moving) void jogger.stop();
    };
    document.addEventListener("keydown", stop, true);
    return () => document.removeEventListener("keydown", stop, true);
  }, []);
}
