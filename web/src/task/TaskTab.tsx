import { Stack, Text } from "@mantine/core";
import { useElementSize } from "@mantine/hooks";
import { lazy, useState } from "react";
import { useTranslation } from "react-i18next";
import { Part } from "../app/Part";
import { useTab } from "../app/useTab";
import { useStation } from "../live/station";
import { detailOf, type Place, placeOf } from "./address";
import { JobView } from "./JobView";
import { Lists, ListsDrawer } from "./Lists";
import classes from "./task.module.css";
import { TaskView } from "./TaskView";
import { useTask } from "./useRun";

const SequenceView = lazy(() => import("./SequenceView"));
const ROOM = 700; // px: with less the list is behind a button

/** What the robots do and did, and sequences of steps that people put together (Fig. 4 of the paper). */
export default function TaskTab() {
  const { ref, width } = useElementSize();
  const [, openTab, detail] = useTab();
  const present = usePresent();
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

/** Name of what is under way, and after its end still of that, so that it can be looked at. */
function usePresent(): string | null {
  const present = useStation(({ state }) => state?.tasks[0]?.name ?? null);
  const [last, setLast] = useState(present);
  if (present !== null && present !== last) setLast(present);
  return present ?? last;
}

/** Nothing was chosen: what is under way is what people want to see. */
function Nothing({ present }: { present: string | null }) {
  const { t } = useTranslation("task");
  if (present !== null) return <Present name={present} />;
  return (
    <Stack p="md">
      <Text>{t("nothing.idle")}</Text>
      <Text c="dimmed">{t("nothing.choose")}</Text>
    </Stack>
  );
}

/** What is under way now: of a job the job, to which the commands belong. */
function Present({ name }: { name: string }) {
  const { data: task } = useTask(name);
  if (task === undefined) return null;
  return task.job === "" ? <TaskView key={name} name={name} /> : <JobView key={name} id={task.job} />;
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
