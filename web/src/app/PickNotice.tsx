import { Alert, Button, Group } from "@mantine/core";
import { IconClick } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { useSelection } from "../selection/selection";

/** Shows that a form waits for a click on an element, what for, and a button to cancel. */
export function PickNotice() {
  const { t } = useTranslation();
  const pick = useSelection((selection) => selection.pick);
  const endPick = useSelection((selection) => selection.endPick);
  return (
    <div role="status">
      {pick && (
        <Alert color="blue" icon={<IconClick aria-hidden />} p="xs" radius={0}>
          <Group justify="space-between">
            {t("pick.waits", { purpose: pick.purpose })}
            <Button variant="default" onClick={endPick}>
              {t("cancel")}
            </Button>
          </Group>
        </Alert>
      )}
    </div>
  );
}
