import { Button, Group } from "@mantine/core";
import {
  IconArrowsMove,
  IconCopy,
  IconAxisX,
  IconHandMove,
  IconPencil,
  IconPlus,
  IconTrash,
} from "@tabler/icons-react";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { useSimulation } from "../../api/cell";
import { type Tool, useTools } from "../../scene3d/tools";
import { useSelection } from "../../selection/selection";
import { MayButton } from "../../widgets/MayButton";
import { AddElement } from "../add/AddElement";
import { RemoveElement } from "../add/RemoveElement";
import { MoveDialog } from "../edit/MoveDialog";
import { useMove } from "../edit/useMove";
import type { Tagged } from "../queries";

type Dialog = "add" | "copy" | "remove" | null;

interface Props {
  tagged: Tagged;
  onEdit: () => void;
}

/** Actions on the selected element. */
export function Actions({ tagged, onEdit }: Props) {
  const { t } = useTranslation("world");
  const [dialog, setDialog] = useState<Dialog>(null);
  const { data: element } = tagged;
  const close = () => setDialog(null);
  return (
    <Group gap={6}>
      <MayButton operation="change_element" leftSection={<IconPencil size={14} aria-hidden />} onClick={onEdit}>
        {t("actions.edit")}
      </MayButton>
      <MayButton
        operation="add_element"
        variant="default"
        leftSection={<IconPlus size={14} aria-hidden />}
        onClick={() => setDialog("add")}
      >
        {t("actions.add")}
      </MayButton>
      <MayButton
        operation="add_element"
        variant="default"
        leftSection={<IconCopy size={14} aria-hidden />}
        onClick={() => setDialog("copy")}
      >
        {t("actions.copy")}
      </MayButton>
      {element.placement && <MoveButton tagged={tagged} />}
      <ToolButtons />
      <MayButton
        operation="remove_element"
        variant="default"
        leftSection={<IconTrash size={14} aria-hidden />}
        onClick={() => setDialog("remove")}
      >
        {t("actions.remove")}
      </MayButton>
      {dialog === "add" && <AddElement parent={element} onClose={close} />}
      {dialog === "copy" && <AddElement parent={null} like={element} onClose={close} />}
      {dialog === "remove" && <RemoveElement tagged={tagged} onClose={close} />}
    </Group>
  );
}

/** Waits for a click on the new place, in the tree or in the 3D view: the keyboard's equivalent of dragging. */
function MoveButton({ tagged: { data } }: { tagged: Tagged }) {
  const { t } = useTranslation("world");
  const move = useMove();
  const awaitPick = useSelection((selection) => selection.awaitPick);
  const pick = () =>
    awaitPick({
      purpose: t("move.pick", { label: data.label }),
      fits: (id) => id !== data.id,
      take: (place) => move.move(data.id, place),
    });
  return (
    <>
      <MayButton
        operation="change_element"
        variant="default"
        leftSection={<IconArrowsMove size={14} aria-hidden />}
        onClick={pick}
      >
        {t("actions.move")}
      </MayButton>
      <MoveDialog move={move} />
    </>
  );
}

/** Activates a tool of the 3D view: moves the belief, or the simulated body without informing the robots. */
function ToolButtons() {
  const { t } = useTranslation("world");
  const { data } = useSimulation();
  return (
    <Button.Group>
      <ToolButton tool="belief" operation="change_element" label={t("actions.belief")} />
      {data?.simulates && <ToolButton tool="body" operation="move_body" label={t("actions.body")} />}
    </Button.Group>
  );
}

interface ToolProps {
  tool: Tool;
  operation: "change_element" | "move_body";
  label: string;
}

function ToolButton({ tool, operation, label }: ToolProps) {
  const on = useTools((tools) => tools.tool === tool);
  const set = useTools((tools) => tools.set);
  const Icon = tool === "body" ? IconHandMove : IconAxisX;
  return (
    <MayButton
      operation={operation}
      variant={on ? "filled" : "default"}
      aria-pressed={on}
      leftSection={<Icon size={14} aria-hidden />}
      onClick={() => set({ tool: on ? "select" : tool })}
    >
      {label}
    </MayButton>
  );
}
