import { Button, Group, Text } from "@mantine/core";
import { IconHandStop, IconHome } from "@tabler/icons-react";
import { useEffect } from "react";
import { useTranslation } from "react-i18next";
import { MayButton } from "../../widgets/MayButton";
import { Status } from "../../widgets/Status";
import classes from "../modules.module.css";
import type { Robot } from "../queries";
import { hand, home } from "./robotHand";

/** What is always in reach while a robot is moved by hand: stop, home, and how the last step went. */
export function HandBar({ robot, disabled }: { robot: Robot; disabled: boolean }) {
  const { t } = useTranslation("modules");
  useEscape();
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
          operation="home_robot"
          variant="default"
          leftSection={<IconHome size={14} aria-hidden />}
          disabled={disabled}
          onClick={() => hand.once(home(robot.id))}
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
