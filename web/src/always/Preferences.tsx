import { ActionIcon, Tooltip, useComputedColorScheme, useMantineColorScheme } from "@mantine/core";
import { IconLanguage, IconMoon, IconSun } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import i18n, { LANGUAGES, type Language } from "../i18n";

/** Switches to the other language. */
export function useOtherLanguage(): { name: string; change: () => void } {
  const { i18n: present } = useTranslation();
  const other: Language = present.language === "de" ? "en" : "de";
  return { name: LANGUAGES[other], change: () => void i18n.changeLanguage(other) };
}

/** Switches between light and dark colours. */
export function useScheme(): { dark: boolean; change: () => void } {
  const { setColorScheme } = useMantineColorScheme();
  const dark = useComputedColorScheme("light") === "dark";
  return { dark, change: () => setColorScheme(dark ? "light" : "dark") };
}

export function LanguageButton() {
  const { t } = useTranslation("always");
  const { name, change } = useOtherLanguage();
  const label = t("language", { name });
  return (
    <Tooltip label={label}>
      <ActionIcon aria-label={label} onClick={change}>
        <IconLanguage size={18} />
      </ActionIcon>
    </Tooltip>
  );
}

export function SchemeButton() {
  const { t } = useTranslation("always");
  const { dark, change } = useScheme();
  const label = dark ? t("light") : t("dark");
  return (
    <Tooltip label={label}>
      <ActionIcon aria-label={label} onClick={change}>
        {dark ? <IconSun size={18} /> : <IconMoon size={18} />}
      </ActionIcon>
    </Tooltip>
  );
}
