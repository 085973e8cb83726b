import { MantineProvider, mergeThemeOverrides } from "@mantine/core";
import { type ReactNode, useMemo } from "react";
import { useTranslation } from "react-i18next";
import { colours, theme } from "./theme";

/** The theme of the pages, with translations for the library's own buttons. */
export function Themed({ children }: { children: ReactNode }) {
  const { t } = useTranslation();
  const close = t("close");
  const worded = useMemo(() => withWords(close), [close]);
  return (
    <MantineProvider theme={worded} cssVariablesResolver={colours} defaultColorScheme="auto">
      {children}
    </MantineProvider>
  );
}

function withWords(close: string) {
  return mergeThemeOverrides(theme, { components: { CloseButton: { defaultProps: { "aria-label": close } } } });
}
