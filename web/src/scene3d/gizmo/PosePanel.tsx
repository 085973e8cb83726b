import { ActionIcon, Alert, Button, Group, Paper, Select, Text, Tooltip } from "@mantine/core";
import { IconArrowsMove, IconCube, IconRotate, IconBrain, IconX } from "@tabler/icons-react";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { ApiProblem } from "../../api/client";
import { useSelection } from "../../selection/selection";
import { problemText } from "../../widgets/problems";
import { useReplay } from "../replay";
import { type GizmoMode, type Tool, useTools } from "../tools";
import type { ViewElement } from "../view";
import { PoseNumbersForm } from "./PoseNumbersForm";
import classes from "./PosePanel.module.css";
import { type Movable, startOf, useBodies, useElement, useMovable, useObstacle } from "./useMovable";
import { useMoveBody, useWriteBelief } from "./useWrite";

type Mover = Exclude<Tool, "select">;

/** The panel of the tool: what it moves, by numbers, and whether that is written. */
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
        <Editor key={`${tool} ${element.id}`} tool={tool} element={element} />
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
        {element !== undefined && `: ${element.label || element.id}`}
      </Text>
      <Tooltip label={t("tool.end")}>
        <ActionIcon size="sm" aria-label={t("tool.end")} onClick={end}>
          <IconX size={14} />
        </ActionIcon>
      </Tooltip>
    </Group>
  );
}

function Editor({ tool, element }: { tool: Mover; element: ViewElement }) {
  const { t } = useTranslation("scene3d");
  const { draft, set } = useTools();
  const bodies = useBodies();
  const [frame, setFrame] = useState<string | null>(null);
  const mine = draft?.element === element.id ? draft : null;
  const pose = mine?.pose ?? startOf(tool, element.id, bodies);
  const writer = useWriter(tool, element.id, mine !== null);
  if (pose === null) return <Text size="sm">{t("obstacle.nowhere")}</Text>;
  const write = () => writer.write(pose, () => set({ draft: null }));
  return (
    <form
      onSubmit={(event) => {
        event.preventDefault();
        if (mine !== null && !writer.busy) write();
      }}
    >
      <Text size="xs" c="dimmed" mb={4}>
        {t(`tool.${tool}Means`)}
      </Text>
      <Modes place={element.place ?? element.owner} frame={frame} setFrame={setFrame} />
      <PoseNumbersForm
        pose={pose}
        frame={frame}
        onChange={(next) => set({ draft: { element: element.id, pose: next } })}
      />
      {writer.problem !== null && <Refusal problem={writer.problem} again={() => writer.refresh()} />}
      <Group gap={6} mt={8} justify="flex-end">
        <Button variant="default" disabled={mine === null} onClick={() => set({ draft: null })}>
          {t("cancel", { ns: "common" })}
        </Button>
        <Button
          type="submit"
          disabled={mine === null}
          loading={writer.busy}
          color={tool === "body" ? "orange.8" : undefined}
        >
          {t("apply", { ns: "common" })}
        </Button>
      </Group>
    </form>
  );
}

/** What was refused; where somebody else was quicker, what that means and how to go on. */
function Refusal({ problem, again }: { problem: Error; again: () => void }) {
  const { t } = useTranslation("scene3d");
  const conflict = problem instanceof ApiProblem && problem.status === 412;
  return (
    <Alert color={conflict ? "yellow" : "red"} p={6} mt={6} title={conflict ? t("conflict.title") : undefined}>
      <Text size="xs">{conflict ? t("conflict.text") : problemText(problem)}</Text>
      {conflict && (
        <Button size="compact-xs" variant="default" mt={4} onClick={again}>
          {t("conflict.mine")}
        </Button>
      )}
    </Alert>
  );
}

function useWriter(tool: Mover, id: string, drafted: boolean) {
  const { data: now, refetch } = useMovable(id, tool === "belief");
  const [based, setBased] = useState<Movable | undefined>();
  if (!drafted && now !== based) setBased(now); // an edit is based on what was there when it began
  const belief = useWriteBelief(id);
  const body = useMoveBody(id);
  const current = tool === "body" ? body : belief;
  return {
    busy: current.isPending,
    problem: current.error,
    refresh: () => {
      belief.reset();
      void refetch().then(({ data }) => setBased(data));
    },
    write: (pose: Parameters<typeof body.mutate>[0], done: () => void) => {
      if (tool === "body") body.mutate(pose, { onSuccess: done });
      else if (based !== undefined) belief.mutate({ pose, movable: based }, { onSuccess: done });
    },
  };
}

const MODES: Record<GizmoMode, typeof IconRotate> = { translate: IconArrowsMove, rotate: IconRotate };

function Modes({
  place,
  frame,
  setFrame,
}: {
  place: string | null;
  frame: string | null;
  setFrame: (id: string | null) => void;
}) {
  const { t } = useTranslation("scene3d");
  const { mode, snap, set } = useTools();
  const frames = [{ value: "", label: t("pose.map") }, ...(place === null ? [] : [{ value: place, label: place }])];
  return (
    <Group gap={4} mb={6} align="end" wrap="nowrap">
      {Object.entries(MODES).map(([name, Icon]) => (
        <Tooltip key={name} label={t(`pose.${name as GizmoMode}`)}>
          <ActionIcon
            variant={mode === name ? "filled" : "default"}
            aria-label={t(`pose.${name as GizmoMode}`)}
            aria-pressed={mode === name}
            onClick={() => set({ mode: name as GizmoMode })}
          >
            <Icon size={16} />
          </ActionIcon>
        </Tooltip>
      ))}
      <Select
        aria-label={t("pose.snap")}
        data={SNAPS.map(({ value, label }) => ({ value, label: label || t("pose.free") }))}
        value={String(snap.translate)}
        allowDeselect={false}
        w={92}
        onChange={(value) => set({ snap: SNAPS.find((one) => one.value === value)?.snap ?? snap })}
      />
      <Select
        aria-label={t("pose.frame")}
        data={frames}
        value={frame ?? ""}
        allowDeselect={false}
        flex={1}
        onChange={(value) => setFrame(value || null)}
      />
    </Group>
  );
}

const SNAPS = [
  [0, 0, ""],
  [0.001, 1, "1 mm, 1°"],
  [0.01, 5, "1 cm, 5°"],
  [0.1, 15, "10 cm, 15°"],
].map(([length, degrees, label]) => ({
  value: String(length),
  label: String(label),
  snap: { translate: Number(length), rotate: (Number(degrees) * Math.PI) / 180 },
}));
