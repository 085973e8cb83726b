import { IconArrowBackUp } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { answer, api } from "../../api/client";
import { HistoryButtons } from "../../widgets/HistoryButtons";
import { MayButton } from "../../widgets/MayButton";
import { withdrawUndo } from "../../widgets/toasts";
import { said } from "../../i18n/sentences";
import { useWrite } from "../edit/useWrite";
import { useWorldInfo } from "../queries";

function inWords<Change extends { reason: string }>(change: Change): Change {
  return { ...change, reason: said(change.reason) };
}

function useUndo() {
  return useWrite(
    (change: number) => answer(api.POST("/api/v1/world/undo", { body: { change } })),
    () => withdrawUndo(),
  );
}

/** Undoes and redoes the edits of people, and describes them. */
export function WorldHistory() {
  const { t } = useTranslation("world");
  const { data } = useWorldInfo();
  const undo = useUndo();
  const redo = useWrite((change: number) => answer(api.POST("/api/v1/world/redo", { body: { change } })));
  const [back, again] = [data?.undoable ?? null, data?.redoable ?? null];
  return (
    <HistoryButtons
      operation="undo_edit"
      undo={back && (() => undo.mutate(back.number))}
      redo={again && (() => redo.mutate(again.number))}
      titles={{
        undo: back === null ? t("undo.nothing") : t("undo.what", inWords(back)),
        redo: again === null ? t("redo.nothing") : t("redo.what", inWords(again)),
      }}
      busy={undo.isPending || redo.isPending}
    />
  );
}

/** Undoes one change if it is the last edit of a person; otherwise nothing is shown. */
export function UndoButton({ only }: { only: number }) {
  const { t } = useTranslation("world");
  const next = useWorldInfo().data?.undoable ?? null;
  const undo = useUndo();
  if (next?.number !== only) return null;
  return (
    <MayButton
      operation="undo_edit"
      variant="default"
      leftSection={<IconArrowBackUp size={14} aria-hidden />}
      loading={undo.isPending}
      title={t("undo.what", inWords(next))}
      aria-label={t("undo.what", inWords(next))}
      onClick={() => undo.mutate(next.number)}
    >
      {t("undo.short")}
    </MayButton>
  );
}
