import { createTheme } from "@mantine/core";

/** Contrast of text at least 4.5 : 1 in both colour schemes; dense enough for 1024 px. */
export const theme = createTheme({
  primaryColor: "blue",
  primaryShade: { light: 8, dark: 7 },
  autoContrast: true,
  luminanceThreshold: 0.35,
  defaultRadius: "sm",
  focusRing: "auto",
  cursorType: "pointer",
  fontSizes: { xs: "0.75rem", sm: "0.83rem", md: "0.9rem", lg: "1rem", xl: "1.15rem" },
  components: {
    Button: { defaultProps: { size: "xs" } },
    ActionIcon: { defaultProps: { size: "md", variant: "subtle" } },
    TextInput: { defaultProps: { size: "xs" } },
    NumberInput: { defaultProps: { size: "xs" } },
    Select: { defaultProps: { size: "xs", checkIconPosition: "right" } },
    Textarea: { defaultProps: { size: "xs" } },
    Tooltip: { defaultProps: { openDelay: 400, withArrow: true, events: { hover: true, focus: true, touch: true } } },
  },
});
