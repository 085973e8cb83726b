import { IconArrowBackUp, IconArrowForwardUp } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import type { Operation } from "../api/session";
import { type History, useHistoryKeys } from "./history";
import { MayButton } from "./MayButton";

interface Props extends History {
  operation: Operation;
  /** What would be undone and redone, in words. */
  titles?: { undo: string; redo: string };
  busy?: boolean;
}

/** Undo and redo as buttons, which the keys press as well. */
export function HistoryButtons({ operation, undo, redo, titles, busy = false }: Props) {
  const { t } = useTranslation();
  useHistoryKeys(busy ? { undo: null, redo: null } : { undo, redo });
  return (
    <>
      {[
        { name: "undo" as const, act: undo, Icon: IconArrowBackUp, keys: "Control+Z" },
        { name: "redo" as const, act: redo, Icon: IconArrowForwardUp, keys: "Control+Shift+Z" },
      ].map(({ name, act, Icon, keys }) => (
        <MayButton
          key={name}
          operation={operation}
          variant="default"
          leftSection={<Icon size={14} aria-hidden />}
          disabled={act === null || busy}
          title={titles?.[name] ?? t(name)}
          aria-label={titles?.[name] ?? t(name)}
          aria-keyshortcuts={keys}
          onClick={() => act?.()}
        >
          {t(name)}
        </MayButton>
      ))}
    </>
  );
}
