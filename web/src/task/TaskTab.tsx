import { Stack, Text } from "@mantine/core";
import { useElementSize } from "@mantine/hooks";
import { lazy, useEffect, useState } from "react";
import { useTranslation } from "react-i18next";
import { ApiProblem } from "../api/client";
import { Part } from "../app/Part";
import { comesBackTo, useTab } from "../app/useTab";
import { useStation } from "../live/station";
import { detailOf, type Place, placeOf } from "./address";
import { JobView } from "./JobView";
import { selectionToRestore, lastTask, remember } from "./lastSelection";
import { Lists, ListsDrawer } from "./Lists";
import { Problem } from "./Problem";
import classes from "./task.module.css";
import { TaskView } from "./TaskView";
import { useTask } from "./useRun";

const SequenceView = lazy(() => import("./SequenceView"));
const ROOM = 700; // px: in narrower windows the list is behind a button

// Returning to the tab shows its last content; its button leads from there to the running task.
comesBackTo("task", (isOpen) => (isOpen ? "" : selectionToRestore(underWay())));

/** Past and running tasks, and sequences of steps created by people (Fig. 4 of the paper). */
export default function TaskTab() {
  const { ref, width } = useWidth();
  const [, openTab, detail] = useTab();
  const present = usePresent();
  useEffect(() => remember({ detail, task: present }), [detail, present]);
  const chosen = placeOf(detail);
  const open = (place: Place) => openTab("task", detailOf(place));
  const wide = width >= ROOM;
  return (
    <div ref={ref} className={classes.root}>
      {width > 0 && (
        <div className={wide ? classes.wide : undefined}>
          {wide ? (
            <Lists key={chosen?.kind} current={chosen} open={open} />
          ) : (
            <ListsDrawer current={chosen} open={open} />
          )}
          <div className={classes.content}>
            {chosen === null ? <Nothing present={present} /> : <Chosen place={chosen} />}
          </div>
        </div>
      )}
    </div>
  );
}

/** Width of an element; its last one while hidden, as the page is while a part of it is printed [px]. */
function useWidth() {
  const { ref, width } = useElementSize();
  const [last, setLast] = useState(width);
  if (width > 0 && width !== last) setLast(width);
  return { ref, width: last };
}

/** The running task; null for none. */
function underWay({ state } = useStation.getState()): string | null {
  return state?.tasks[0]?.name ?? null;
}

/** The running task, or the last one after its end, so that it stays visible. */
function usePresent(): string | null {
  const present = useStation(underWay);
  const [last, setLast] = useState(present ?? lastTask());
  if (present !== null && present !== last) setLast(present);
  return present ?? last;
}

/** By default, the running task is shown. */
function Nothing({ present }: { present: string | null }) {
  return present === null ? <Idle /> : <Present name={present} />;
}

function Idle() {
  const { t } = useTranslation("task");
  return (
    <Stack p="md">
      <Text>{t("nothing.idle")}</Text>
      <Text c="dimmed">{t("nothing.choose")}</Text>
    </Stack>
  );
}

/** The running task, or its job, which has the commands. */
function Present({ name }: { name: string }) {
  const { data: task, error, refetch } = useTask(name);
  if (task === undefined) {
    if (error === null) return null;
    return isForgotten(error) ? <Idle /> : <Problem error={error} again={refetch} />;
  }
  return task.job === "" ? <TaskView key={name} name={name} /> : <JobView key={name} id={task.job} />;
}

/** Whether the server no longer knows it, after a restart. */
function isForgotten(error: Error): boolean {
  return error instanceof ApiProblem && error.status === 404;
}

function Chosen({ place }: { place: Place }) {
  if (place.kind === "sequence") {
    return (
      <Part key={place.id}>
        <SequenceView id={place.id} />
      </Part>
    );
  }
  return place.kind === "task" ? <TaskView key={place.id} name={place.id} /> : <JobView key={place.id} id={place.id} />;
}
