import { Group, Stack } from "@mantine/core";
import { useDebouncedValue } from "@mantine/hooks";
import { IconPlus } from "@tabler/icons-react";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { MayButton } from "../widgets/MayButton";
import { useMay } from "../api/session";
import { AddElement } from "./add/AddElement";
import { WorldHistory } from "./changes/UndoButton";
import { ElementDetails } from "./details/ElementDetails";
import { MoveDialog } from "./edit/MoveDialog";
import { useMove } from "./edit/useMove";
import { Found } from "./tree/Found";
import { SceneTree } from "./tree/SceneTree";
import { type Search, TreeSearch } from "./tree/TreeSearch";
import { Split } from "./Split";
import classes from "./World.module.css";

const SEARCH_PAUSE = 60; // ms

/** The scene as a tree, beside the details of the selected element. */
export function SceneView() {
  const { t } = useTranslation("world");
  return <Split divider={t("tree.divider")} list={<TreePane />} details={<ElementDetails />} />;
}

function TreePane() {
  const [search, setSearch] = useState<Search>({ text: "", class_: null });
  const [asked] = useDebouncedValue(search, SEARCH_PAUSE);
  const may = useMay("change_element");
  const move = useMove();
  const searching = asked.text !== "" || asked.class_ !== null;
  return (
    <Stack gap={6} className={classes.fill}>
      <TreeSearch search={search} onChange={setSearch} />
      <div className={classes.tree}>
        {searching ? <Found search={asked} /> : <SceneTree onMove={may ? move.move : undefined} />}
      </div>
      <Footer />
      <MoveDialog move={move} />
    </Stack>
  );
}

function Footer() {
  const { t } = useTranslation("world");
  const [adding, setAdding] = useState(false);
  return (
    <Group gap={6} pb={4}>
      <MayButton
        operation="add_element"
        variant="default"
        leftSection={<IconPlus size={14} aria-hidden />}
        onClick={() => setAdding(true)}
      >
        {t("add.anywhere")}
      </MayButton>
      <WorldHistory />
      {adding && <AddElement parent={null} onClose={() => setAdding(false)} />}
    </Group>
  );
}
