import {
  type Announcements,
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
import { type ReactNode, type RefObject, useEffect, useRef } from "react";
import { useTranslation } from "react-i18next";
import { useMay } from "../api/session";
import { Status } from "../widgets/Status";
import type { Skills } from "../api/cell";
import { OpenStepForm } from "./OpenStepForm";
import { type Edit, fateOf, type Sequence, type Step, type useEdits } from "./sequences";
import type { StepForms } from "./stepForms";
import classes from "./task.module.css";
import { stepTitle } from "./words";

interface Props {
  sequence: Sequence;
  skills: Skills;
  pending: boolean;
  edit: ReturnType<typeof useEdits>["edit"];
  forms: StepForms;
}

/** The steps of a sequence with their problems; reordered by pointer, keys or buttons. */
export function SequenceSteps(props: Props) {
  const { sequence, edit, pending } = props;
  const { t } = useTranslation("task");
  const sensors = useSensors(
    useSensor(PointerSensor),
    useSensor(KeyboardSensor, { coordinateGetter: sortableKeyboardCoordinates }),
  );
  const list = useRef<HTMLDivElement>(null);
  const follow = useFocusFollowing(list, sequence.version, pending);
  const editAndFollow = (change: Edit, to: { at: number; by: Mover }) => {
    const following = follow(to);
    edit(change, {
      onSettled: (_, refusal) => {
        if (refusal !== null) following.end();
      },
    });
  };
  const move = (at: number, to: number, by: Mover) => editAndFollow({ kind: "move", at, to }, { at: to, by });
  // Then the step that is there now has the focus, but not its bin: a second press must not remove it as well.
  const remove = (at: number) =>
    editAndFollow({ kind: "remove", at }, { at: Math.min(at, sequence.count - 2), by: "drag" });
  const ids = sequence.steps.map((_, index) => String(index + 1)); // "0" is not a valid id
  const end = ({ active, over }: DragEndEvent) => {
    if (over === null || active.id === over.id) return;
    move(Number(active.id) - 1, Number(over.id) - 1, "drag");
  };
  const announcements: Announcements = {
    onDragStart: ({ active }) => t("step.lifted", { at: active.id }),
    onDragOver: ({ over }) => (over === null ? undefined : t("step.over", { at: over.id })),
    onDragEnd: ({ over }) => (over === null ? t("step.left") : t("step.dropped", { at: over.id })),
    onDragCancel: () => t("step.left"),
  };
  return (
    <DndContext
      sensors={sensors}
      collisionDetection={closestCenter}
      onDragEnd={end}
      accessibility={{ announcements, screenReaderInstructions: { draggable: t("step.howToMove") } }}
    >
      <SortableContext items={ids} strategy={verticalListSortingStrategy}>
        <Stack gap={4} component="ol" m={0} p={0} aria-label={t("step.list")} ref={list}>
          <Rows {...props} move={move} remove={remove} />
        </Stack>
      </SortableContext>
    </DndContext>
  );
}

/** The control that moved the step. */
type Mover = "drag" | "up" | "down";
type Move = (at: number, to: number, by: Mover) => void;

/**
 * Returns functions that let the focus follow a moved step after rendering, so that it can be moved further.
 * A refused move must be ended, or the focus would move when another person changes the sequence.
 */
function useFocusFollowing(list: RefObject<HTMLElement | null>, version: number, pending: boolean) {
  const wanted = useRef<{ at: number; by: Mover; version: number } | null>(null);
  useEffect(() => {
    if (pending || wanted.current === null || wanted.current.version === version) return;
    const { at, by } = wanted.current;
    wanted.current = null;
    const tools = (name: Mover) => list.current?.querySelector<HTMLElement>(`[data-mover="${name} ${at}"]:enabled`);
    (tools(by) ?? tools("drag"))?.focus();
  }, [list, version, pending]);
  return (to: { at: number; by: Mover }) => {
    wanted.current = { ...to, version };
    return { end: () => void (wanted.current = null) };
  };
}

interface RowsProps extends Props {
  move: Move;
  remove: (at: number) => void;
}

/** The steps with their open forms; forms of removed steps are at the end. */
function Rows({ sequence, skills, pending, edit, forms, move, remove }: RowsProps) {
  const opened = forms.forms.map((form) => ({ form, fate: fateOf(form, sequence) }));
  const formsOf = (index: number | null) =>
    opened.filter(({ fate }) => (fate.fate === "removed" ? null : fate.at) === index);
  const drawn = ({ form, fate }: (typeof opened)[number]) => (
    <OpenStepForm
      key={`form ${form.key}`} // a sibling of the rows, so that it keeps its state wherever its step moves
      form={form}
      fate={fate}
      sequence={sequence}
      skills={skills}
      pending={pending}
      edit={edit}
      close={() => forms.close(form.key)}
    />
  );
  const rows = sequence.steps.flatMap((step, index) => {
    const own = formsOf(index);
    const closeAll = () => own.forEach(({ form }) => forms.close(form.key));
    return [
      <StepRow
        // Position and content: after each edit all rows belong to the new version.
        key={`${sequence.version} ${index}`}
        step={step}
        index={index}
        count={sequence.count}
        skills={skills}
        pending={pending}
        move={move}
        change={() => (own.length > 0 ? closeAll() : forms.open({ seen: sequence, at: index }))}
        changing={own.length > 0}
        remove={() => {
          closeAll();
          remove(index);
        }}
      />,
      ...own.map(drawn),
    ];
  });
  return [...rows, ...formsOf(null).map(drawn)];
}

interface RowProps extends Pick<Props, "skills" | "pending"> {
  step: Step;
  index: number;
  count: number;
  move: Move;
  /** Opens or closes its form. */
  change: () => void;
  changing: boolean;
  remove: () => void;
}

function StepRow({ step, index, count, skills, pending, move, change, changing, remove }: RowProps) {
  const { t } = useTranslation("task");
  const may = useMay("put_document");
  const { setNodeRef, setActivatorNodeRef, attributes, listeners, transform, transition } = useSortable({
    id: String(index + 1),
    disabled: !may || pending,
  });
  const title = stepTitle(step, skills);
  const style = { transform: CSS.Transform.toString(transform), transition, listStyle: "none" };
  return (
    <li ref={setNodeRef} style={style} className={classes.step} aria-label={`${index + 1}. ${title}`}>
      <Group gap={6} wrap="nowrap">
        <ActionIcon
          ref={setActivatorNodeRef}
          {...attributes}
          {...listeners}
          className={classes.handle}
          data-mover={`drag ${index}`}
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
          mover={`up ${index}`}
          act={() => move(index, index - 1, "up")}
        >
          <IconArrowUp size={14} />
        </Tool>
        <Tool
          name={t("step.down", { step: title })}
          disabled={!may || pending || index === count - 1}
          mover={`down ${index}`}
          act={() => move(index, index + 1, "down")}
        >
          <IconArrowDown size={14} />
        </Tool>
        <Tool name={t("step.change", { step: title })} disabled={!may || pending} expanded={changing} act={change}>
          <IconPencil size={14} />
        </Tool>
        <Tool name={t("step.remove", { step: title })} disabled={!may || pending} act={remove}>
          <IconTrash size={14} />
        </Tool>
      </Group>
      {step.works ? null : <Problems step={step} />}
    </li>
  );
}

function Problems({ step: { problems, agent } }: { step: Step }) {
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
  expanded?: boolean;
  mover?: string;
  act: () => void;
  children: ReactNode;
}

function Tool({ name, disabled, expanded, mover, act, children }: ToolProps) {
  return (
    <Tooltip label={name}>
      <ActionIcon
        size="sm"
        aria-label={name}
        aria-expanded={expanded}
        data-mover={mover}
        disabled={disabled}
        onClick={act}
      >
        {children}
      </ActionIcon>
    </Tooltip>
  );
}
