import { Button, Group, Text } from "@mantine/core";
import { notifications } from "@mantine/notifications";
import i18n from "../i18n";

const SHOWN = 6000; // ms
const SHOWN_WITH_UNDO = 12_000; // ms

let offered: string | null = null; // the toast that offers an undo: only the last change can be undone

/**
 * Reports that an action was done.
 *
 * @param undo - Undoes it; offered as a button until another change can be undone.
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
        <Text size="sm" miw={0} style={{ overflowWrap: "anywhere" }}>
          {message}
        </Text>
        {undo && (
          <Button variant="default" flex="none" onClick={takeBack}>
            {i18n.t("undo")}
          </Button>
        )}
      </Group>
    ),
  });
}

/** Withdraws the offer to undo: the change was undone, or another one is the last now. */
export function withdrawUndo(): void {
  if (offered !== null) notifications.hide(offered);
  offered = null;
}
