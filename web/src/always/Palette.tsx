import "@mantine/spotlight/styles.css";
import { useDebouncedValue } from "@mantine/hooks";
import { Spotlight, spotlight } from "@mantine/spotlight";
import { IconSearch } from "@tabler/icons-react";
import { useEffect, useState } from "react";
import { useTranslation } from "react-i18next";
import { usePalette } from "./palette";
import { useActions } from "./useActions";

/** The command palette: finds tabs, commands, scenes, jobs and elements. */
export default function Palette() {
  const { t } = useTranslation("always");
  const asked = usePalette((palette) => palette.asked);
  const [query, setQuery] = useState("");
  const [searched] = useDebouncedValue(query.trim(), 150);
  const [opened, setOpened] = useState(false);
  const actions = useActions(searched, opened);
  useEffect(() => {
    if (asked > 0) spotlight.open();
  }, [asked]);
  return (
    <Spotlight
      shortcut={null}
      actions={actions}
      query={query}
      onQueryChange={setQuery}
      onSpotlightOpen={() => setOpened(true)}
      onSpotlightClose={() => setOpened(false)}
      highlightQuery
      overlayProps={{ backgroundOpacity: 0.35, blur: 0 }} // a blur over the 3D view costs whole seconds a frame
      attributes={{ content: { "aria-label": t("palette.open") } }}
      scrollable
      maxHeight={420}
      scrollAreaProps={{ viewportProps: { tabIndex: 0 } }} // a list longer than that can be scrolled by keys
      limit={30}
      nothingFound={t("palette.nothing")}
      searchProps={{
        leftSection: <IconSearch size={18} aria-hidden />,
        placeholder: t("palette.placeholder"),
        "aria-label": t("palette.placeholder"),
      }}
    />
  );
}
