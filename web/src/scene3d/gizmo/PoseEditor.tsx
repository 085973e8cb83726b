import { Alert, Button, Group, Text } from "@mantine/core";
import { IconArrowBarToDown } from "@tabler/icons-react";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { Vector3 } from "three";
import { ApiProblem } from "../../api/client";
import { problemText } from "../../widgets/problems";
import { crowd, useShowings } from "../elements/crowd";
import { type MapPose, useTools } from "../tools";
import type { ViewElement } from "../view";
import { PoseModes } from "./PoseModes";
import { PoseNumbersForm } from "./PoseNumbersForm";
import { startOf, useBodies, useElement } from "./useMovable";
import { type Mover, useWriter } from "./useWriter";
import { nameNow } from "../../widgets/names";
import { setDown } from "./surfaces";
import { useCollision } from "./useCollision";

const FAR = 0.3; // m from the bounding box of a place

/** Edits a pose as numbers, and writes it. */
export function PoseEditor({ tool, element }: { tool: Mover; element: ViewElement }) {
  const { t } = useTranslation("scene3d");
  const { draft, set } = useTools();
  const bodies = useBodies();
  useShowings(); // the numbers follow the pose as drawn
  const [frame, setFrame] = useState<string | null>(null);
  const [sound, setSound] = useState(true);
  const mine = draft?.element === element.id ? draft : null;
  const pose = mine?.pose ?? startOf(tool, element.id, bodies);
  const writer = useWriter(tool, element.id, mine !== null);
  const hits = useCollision(element.id, mine?.pose ?? null);
  const refused = tool === "body" && hits.length > 0;
  if (pose === null) return <Text size="sm">{t("obstacle.nowhere")}</Text>;
  const write = () => writer.write(pose, () => set({ draft: null }));
  return (
    <form
      onSubmit={(event) => {
        event.preventDefault();
        if (mine !== null && sound && !refused && !writer.busy) write();
      }}
    >
      <Text size="xs" c="dimmed" mb={4}>
        {t(`tool.${tool}Means`)}
      </Text>
      <PoseModes place={element.place ?? element.owner} frame={frame} setFrame={setFrame} />
      <PoseNumbersForm
        pose={pose}
        frame={frame}
        onSound={setSound}
        onChange={(next) => set({ draft: { element: element.id, pose: next } })}
      />
      {mine !== null && tool === "belief" && <Farness pose={mine.pose} place={element.place} />}
      {hits.length > 0 && (
        <Alert color={tool === "body" ? "red" : "yellow"} p={6} mt={6} role="status">
          <Text size="xs">{t(`collision.${tool}`, { names: hits.map(nameNow).join(", ") })}</Text>
        </Alert>
      )}
      {writer.problem !== null && <Refusal problem={writer.problem} again={() => writer.refresh()} />}
      <Group gap={6} mt={8} justify="flex-end">
        <Button
          variant="default"
          mr="auto"
          leftSection={<IconArrowBarToDown size={14} aria-hidden />}
          onClick={() => set({ draft: { element: element.id, pose: setDown(element.id, pose) } })}
        >
          {t("pose.setDown")}
        </Button>
        <Button variant="default" disabled={mine === null} onClick={() => set({ draft: null })}>
          {t("cancel", { ns: "common" })}
        </Button>
        <Button
          type="submit"
          disabled={mine === null || !sound || refused}
          loading={writer.busy}
          color={tool === "body" ? "orange.8" : undefined}
        >
          {t("apply", { ns: "common" })}
        </Button>
      </Group>
    </form>
  );
}

/** Warns that an element would be far from the place where it is believed to be. */
function Farness({ pose, place }: { pose: MapPose; place: string | null }) {
  const { t } = useTranslation("scene3d");
  const label = useElement(place)?.label ?? place;
  const away = place === null ? 0 : (crowd.boundsOf(place)?.distanceToPoint(new Vector3(...pose.position)) ?? 0);
  if (away < FAR) return null;
  return (
    <Text size="xs" c="orange.8" mt={4} role="status">
      {t("far", { place: label, metres: away.toFixed(1) })}
    </Text>
  );
}

/** A refusal; after a concurrent edit, an explanation and the possible actions. */
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
