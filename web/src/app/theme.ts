import {
  createTheme,
  type CSSVariablesResolver,
  darken,
  type MantineColorsTuple,
  type MantineTheme,
} from "@mantine/core";

/**
 * Text has a contrast of at least 4.5 : 1 in both colour schemes; dense enough for 1024 px.
 *
 * Backgrounds brighter than the threshold get black text, since white would have too little contrast.
 */
export const theme = createTheme({
  primaryColor: "blue",
  primaryShade: 8,
  autoContrast: true,
  luminanceThreshold: 0.183,
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

/** Text colours that replace those of the library with too little contrast. */
export const colours: CSSVariablesResolver = (used) => ({
  variables: {},
  light: {
    ...textOf(used, (shades) => darken(shades[9], 0.3)),
    "--mantine-color-dimmed": used.colors.gray[7],
    "--mantine-color-placeholder": used.colors.gray[7],
    "--mantine-color-error": used.colors.red[9],
    "--mantine-color-anchor": used.colors.blue[9],
  },
  dark: {
    ...textOf(used, (shades) => shades[2]),
    "--mantine-color-dimmed": used.colors.dark[1],
    "--mantine-color-placeholder": used.colors.dark[1],
    "--mantine-color-error": used.colors.red[4],
    "--mantine-color-anchor": used.colors.blue[3],
  },
});

/** The text colour for each colour, on the page and on a light background of that colour. */
function textOf(used: MantineTheme, choose: (shades: MantineColorsTuple) => string): Record<string, string> {
  const variables = Object.entries(used.colors).flatMap(([name, shades]) =>
    ["light-color", "text", "outline"].map((kind) => [`--mantine-color-${name}-${kind}`, choose(shades)]),
  );
  return Object.fromEntries(variables);
}
