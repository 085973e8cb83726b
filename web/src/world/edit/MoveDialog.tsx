import { Alert, Button, Group, Modal, Stack } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { Status } from "../../widgets/Status";
import type { Move } from "./useMove";

/** Asks how to place an element where it was dropped, or explains why it cannot be placed there. */
export function MoveDialog({ move }: { move: Move }) {
  const { t } = useTranslation(["world", "common"]);
  const { question, close, put } = move;
  if (question === null) return null;
  const { element, place, fits } = question;
  const none = fits.every((fit) => !fit.fits);
  return (
    <Modal opened onClose={close} title={t("move.title", { element: element.data.label, place })}>
      <Stack>
        {none && <Alert color="orange">{t("move.cannot")}</Alert>}
        {fits.length === 0 && t("placement.wrongClass")}
        {fits.map((fit) => (
          <Group key={fit.relation} gap="xs">
            <Button
              disabled={!fit.fits}
              variant={fit.relation === element.data.placement?.relation ? "filled" : "default"}
              onClick={() => put(question, fit.relation)}
            >
              {fit.label} {place}
            </Button>
            {!fit.fits && (
              <>
                <Status mood="bad" text={t("placement.fitsNot")} /> {fit.whyNot}
              </>
            )}
          </Group>
        ))}
        <Group justify="end">
          <Button variant="default" onClick={close}>
            {t("common:cancel")}
          </Button>
        </Group>
      </Stack>
    </Modal>
  );
}
