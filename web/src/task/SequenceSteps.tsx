import {
  closestCenter,
  DndContext,
  type DragEndEvent,
  KeyboardSensor,
  PointerSensor,
  useSensor,
  useSensors,
} from "@dnd-kit/core";
import {
  SortableContext,
  sortableKeyboardCoordinates,
  useSortable,
  verticalListSortingStrategy,
} from "@dnd-kit/sortable";
import { CSS } from "@dnd-kit/utilities";
import { ActionIcon, Group, Stack, Text, Tooltip } from "@mantine/core";
import { IconArrowDown, IconArrowUp, IconGripVertical, IconPencil, IconTrash } from "@tabler/icons-react";
import { type ReactNode, useState } from "react";
import { useTranslation } from "react-i18next";
import type { Schema } from "../api/client";
import { useMay } from "../api/session";
import { Status } from "../widgets/Status";
import type { Skills } from "./schedule";
import type { Edit, Sequence } from "./sequences";
import { StepForm } from "./StepForm";
import classes from "./task.module.css";
import { stepTitle } from "./words";

interface Props {
  sequence: Sequence;
  skills: Skills;
  pending: boolean;
  edit: (edit: Edit) => void;
}

/** The steps of a sequence, each with what speaks against it; put in order by mouse, by keys or by buttons. */
export function SequenceSteps({ sequence, skills, pending, edit }: Props) {
  const { t } = useTranslation("task");
  const sensors = useSensors(
    useSensor(PointerSensor),
    useSensor(KeyboardSensor, { coordinateGetter: sortableKeyboardCoordinates }),
  );
  const ids = sequence.steps.map((_, index) => String(index + 1)); // "0" would be no id
  const end = ({ active, over }: DragEndEvent) => {
    if (over === null || active.id === over.id) return;
    edit({ kind: "move", at: Number(active.id) - 1, to: Number(over.id) - 1 });
  };
  return (
    <DndContext
      sensors={sensors}
      collisionDetection={closestCenter}
      onDragEnd={end}
      accessibility={{ screenReaderInstructions: { draggable: t("step.howToMove") } }}
    >
      <SortableContext items={ids} strategy={verticalListSortingStrategy}>
        <Stack gap={4} component="ol" m={0} p={0} aria-label={t("step.list")}>
          {sequence.steps.map((step, index) => (
            <StepRow
              // Its place and what it is: after each edit all rows are those of the new version.
              key={`${sequence.version} ${index}`}
              step={step}
              index={index}
              count={sequence.count}
              skills={skills}
              pending={pending}
              edit={edit}
            />
          ))}
        </Stack>
      </SortableContext>
    </DndContext>
  );
}

interface RowProps extends Omit<Props, "sequence"> {
  step: Schema<"CheckedStep">;
  index: number;
  count: number;
}

function StepRow({ step, index, count, skills, pending, edit }: RowProps) {
  const { t } = useTranslation("task");
  const may = useMay("move_step");
  const [changing, setChanging] = useState(false);
  const { setNodeRef, setActivatorNodeRef, attributes, listeners, transform, transition } = useSortable({
    id: String(index + 1),
    disabled: !may || pending,
  });
  const title = stepTitle(step, skills);
  const style = { transform: CSS.Transform.toString(transform), transition, listStyle: "none" };
  const move = (to: number) => edit({ kind: "move", at: index, to });
  return (
    <li ref={setNodeRef} style={style} className={classes.step} aria-label={`${index + 1}. ${title}`}>
      <Group gap={6} wrap="nowrap">
        <ActionIcon
          ref={setActivatorNodeRef}
          {...attributes}
          {...listeners}
          className={classes.handle}
          size="sm"
          aria-label={t("step.drag", { step: title })}
          disabled={!may}
        >
          <IconGripVertical size={14} />
        </ActionIcon>
        <Text size="sm" fw={600} flex={1} truncate>
          {`${index + 1}. ${title}`}
        </Text>
        <Text size="xs" c="dimmed">
          {step.agent}
        </Text>
        <Tool
          name={t("step.up", { step: title })}
          disabled={!may || pending || index === 0}
          act={() => move(index - 1)}
        >
          <IconArrowUp size={14} />
        </Tool>
        <Tool
          name={t("step.down", { step: title })}
          disabled={!may || pending || index === count - 1}
          act={() => move(index + 1)}
        >
          <IconArrowDown size={14} />
        </Tool>
        <Tool name={t("step.change", { step: title })} disabled={!may || pending} act={() => setChanging(!changing)}>
          <IconPencil size={14} />
        </Tool>
        <Tool
          name={t("step.remove", { step: title })}
          disabled={!may || pending}
          act={() => edit({ kind: "remove", at: index })}
        >
          <IconTrash size={14} />
        </Tool>
      </Group>
      {step.works ? null : <Problems step={step} />}
      {changing && (
        <StepForm
          skills={skills}
          step={step}
          label={t("step.save")}
          pending={pending}
          save={(next) => edit({ kind: "change", at: index, step: next })}
          cancel={() => setChanging(false)}
        />
      )}
    </li>
  );
}

function Problems({ step: { problems, agent } }: { step: Schema<"CheckedStep"> }) {
  const { t } = useTranslation("task");
  return (
    <Group gap="xs" align="start" wrap="nowrap" pl={30}>
      <Status mood="warning" text={t("step.worksNot")} />
      <div>
        {problems.map((problem) => (
          <Text key={problem} size="sm">
            {problem}
          </Text>
        ))}
        {problems.length === 0 && agent === "" && <Text size="sm">{t("step.nobody")}</Text>}
      </div>
    </Group>
  );
}

interface ToolProps {
  name: string;
  disabled: boolean;
  act: () => void;
  children: ReactNode;
}

function Tool({ name, disabled, act, children }: ToolProps) {
  return (
    <Tooltip label={name}>
      <ActionIcon size="sm" aria-label={name} disabled={disabled} onClick={act}>
        {children}
      </ActionIcon>
    </Tooltip>
  );
}
