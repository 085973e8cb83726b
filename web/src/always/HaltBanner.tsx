import { IconHandStop } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { MayButton } from "../widgets/MayButton";
import { Moment } from "../widgets/Moment";
import { Banner } from "./Banner";
import { useDialogs } from "./dialogs";
import { useHalt } from "./useHalt";
import { said } from "../i18n/sentences";

/** Everything is halted: reason, author and time, and how to continue. */
export function HaltBanner() {
  const { t } = useTranslation("always");
  const halt = useHalt();
  const open = useDialogs((dialogs) => dialogs.open);
  if (!halt?.halted) return null;
  const reset = (
    <MayButton operation="reset" color="red" onClick={() => open("reset")}>
      {t("reset.label")}
    </MayButton>
  );
  return (
    <Banner tone="red" icon={IconHandStop} title={t("halt.title")} actions={reset}>
      {said(halt.why)} {halt.by && t("halt.by", { name: halt.by })} · <Moment at={halt.since} />
      {!halt.obeyed && <strong> {t("halt.unheard")}</strong>}
    </Banner>
  );
}
