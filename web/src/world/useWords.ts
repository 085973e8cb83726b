import { useTranslation } from "react-i18next";

/** Texts for values. */
export function useWords(): { yes: string; no: string; none: string } {
  const { t } = useTranslation("world");
  return { yes: t("value.yes"), no: t("value.no"), none: t("value.none") };
}
