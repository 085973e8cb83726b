import { Button, Group, Text } from "@mantine/core";
import { notifications } from "@mantine/notifications";
import i18n from "../i18n";

const SHOWN = 6000; // ms
const SHOWN_WITH_UNDO = 12_000; // ms

let offered: string | null = null; // the toast that offers to take something back: only the last change can be

/**
 * Says that something was done.
 *
 * @param undo - Takes it back; offered as a button where it is given, until something else can be taken back.
 */
export function notifyDone(message: string, undo?: () => void): void {
  const id = crypto.randomUUID?.() ?? String(Math.random());
  if (undo) {
    withdrawUndo();
    offered = id;
  }
  const takeBack = () => {
    notifications.hide(id);
    undo?.();
  };
  notifications.show({
    id,
    color: "green",
    autoClose: undo ? SHOWN_WITH_UNDO : SHOWN,
    message: (
      <Group justify="space-between" wrap="nowrap">
        <Text size="sm">{message}</Text>
        {undo && (
          <Button variant="default" onClick={takeBack}>
            {i18n.t("undo")}
          </Button>
        )}
      </Group>
    ),
  });
}

/** Ends the offer to take something back: it was taken back, or something else can be now. */
export function withdrawUndo(): void {
  if (offered !== null) notifications.hide(offered);
  offered = null;
}
