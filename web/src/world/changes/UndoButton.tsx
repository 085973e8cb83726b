import { IconArrowBackUp } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { answer, api } from "../../api/client";
import { MayButton } from "../../widgets/MayButton";
import { withdrawUndo } from "../../widgets/toasts";
import { useWrite } from "../edit/useWrite";
import { useWorldInfo } from "../queries";

/** Undoes the last edit by a person, and describes it; with `only`, it is shown for that change alone. */
export function UndoButton({ only }: { only?: number }) {
  const { t } = useTranslation("world");
  const { data } = useWorldInfo();
  const next = data?.undoable ?? null;
  const undo = useWrite(
    (change: number) => answer(api.POST("/api/v1/world/undo", { body: { change } })),
    () => withdrawUndo(),
  );
  if (only !== undefined && next?.number !== only) return null;
  const what = next === null ? t("undo.nothing") : t("undo.what", next);
  return (
    <MayButton
      operation="undo_edit"
      variant="default"
      leftSection={<IconArrowBackUp size={14} aria-hidden />}
      disabled={next === null}
      loading={undo.isPending}
      title={what}
      aria-label={what}
      onClick={() => next && undo.mutate(next.number)}
    >
      {t("undo.short")}
    </MayButton>
  );
}
