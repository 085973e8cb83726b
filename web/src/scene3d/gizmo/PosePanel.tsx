import { ActionIcon, Group, Paper, Text, Tooltip } from "@mantine/core";
import { IconBrain, IconCube, IconX } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { useSelection } from "../../selection/selection";
import { useReplay } from "../replay";
import { useTools } from "../tools";
import type { ViewElement } from "../view";
import { PoseEditor } from "./PoseEditor";
import classes from "./PosePanel.module.css";
import { useElement, useObstacle } from "./useMovable";
import type { Mover } from "./useWriter";
import { nameOf } from "../../widgets/names";

/** The panel of the move tool: its element, its pose as numbers, and buttons to write it. */
export function PosePanel() {
  const { t } = useTranslation("scene3d");
  const { tool, set } = useTools();
  const selected = useSelection((state) => state.selected);
  const element = useElement(selected);
  const past = useReplay((state) => state.replay !== null);
  const obstacle = useObstacle(tool, element);
  if (tool === "select") return null;
  const end = () => set({ tool: "select", draft: null });
  return (
    <Paper
      role="region"
      aria-label={t(`tool.${tool}`)}
      className={classes.panel}
      data-tool={tool}
      shadow="md"
      withBorder
    >
      <Title tool={tool} element={element} end={end} />
      {element === undefined ? (
        <Text size="sm">{t("tool.choose")}</Text>
      ) : past || obstacle !== null ? (
        <Text size="sm">{t(`obstacle.${past ? "replayed" : (obstacle ?? "replayed")}`)}</Text>
      ) : (
        <PoseEditor key={`${tool} ${element.id}`} tool={tool} element={element} />
      )}
    </Paper>
  );
}

function Title({ tool, element, end }: { tool: Mover; element: ViewElement | undefined; end: () => void }) {
  const { t } = useTranslation("scene3d");
  const Icon = tool === "body" ? IconCube : IconBrain;
  return (
    <Group gap={6} wrap="nowrap" mb={6}>
      <Icon size={18} aria-hidden />
      <Text size="sm" fw={600} flex={1} truncate>
        {t(`tool.${tool}`)}
        {element !== undefined && `: ${nameOf(element.id, element.label)}`}
      </Text>
      <Tooltip label={t("tool.end")}>
        <ActionIcon size="sm" aria-label={t("tool.end")} onClick={end}>
          <IconX size={14} />
        </ActionIcon>
      </Tooltip>
    </Group>
  );
}
