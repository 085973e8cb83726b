import { Box, Drawer, Button, ScrollArea, SegmentedControl, Stack, Text } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { IconList } from "@tabler/icons-react";
import { useQuery } from "@tanstack/react-query";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, api } from "../api/client";
import { keys } from "../api/keys";
import { Status } from "../widgets/Status";
import type { Place } from "./address";
import { Entry } from "./Entry";
import { JobList } from "./JobList";
import { NewSequenceButton } from "./NewSequenceButton";
import { Problem } from "./Problem";
import { useSequences } from "./sequences";
import classes from "./task.module.css";
import { taskState } from "./taskWords";
import { taskMood } from "./words";

export interface ListProps {
  current: Place | null;
  open: (place: Place) => void;
}

type Shown = Place["kind"];

/** Lists of jobs, other tasks, and sequences. */
export function Lists({ current, open }: ListProps) {
  const { t } = useTranslation("task");
  const [shown, show] = useState<Shown>(current?.kind ?? "job");
  const data = (["job", "task", "sequence"] as const).map((value) => ({ value, label: t(`lists.${value}`) }));
  return (
    <div className={classes.list}>
      <SegmentedControl
        size="xs"
        fullWidth
        aria-label={t("lists.label")}
        data={data}
        value={shown}
        onChange={(value) => show(value as Shown)}
      />
      {shown === "job" && <JobList current={current} open={open} />}
      {shown === "task" && <TaskList current={current} open={open} />}
      {shown === "sequence" && <SequenceList current={current} open={open} />}
    </div>
  );
}

/** The lists in a drawer, if there is no room beside the selected entry. */
export function ListsDrawer({ current, open }: ListProps) {
  const { t } = useTranslation("task");
  const [opened, { open: show, close }] = useDisclosure(false);
  return (
    <>
      <Button
        variant="default"
        leftSection={<IconList size={14} aria-hidden />}
        onClick={show}
        aria-expanded={opened}
        mb="xs"
      >
        {current === null ? t("lists.choose") : t("lists.other")}
      </Button>
      <Drawer opened={opened} onClose={close} title={t("lists.choose")} size="xs" position="right">
        <Box h="calc(100dvh - 90px)">
          <Lists
            current={current}
            open={(place) => {
              open(place);
              close();
            }}
          />
        </Box>
      </Drawer>
    </>
  );
}

function TaskList({ current, open }: ListProps) {
  const { t } = useTranslation("task");
  const { data, error, refetch } = useQuery({
    queryKey: keys.tasks("list"),
    queryFn: () => answer(api.GET("/api/v1/tasks")),
  });
  const tasks = data?.items.filter(({ job }) => job === "") ?? [];
  if (error !== null) return <Problem error={error} again={refetch} />;
  if (tasks.length === 0) return <Text c="dimmed">{t("list.noTasks")}</Text>;
  return (
    <ScrollArea flex={1} mih={0}>
      <Stack gap={2}>
        {tasks.map((task) => (
          <Entry
            key={task.name}
            title={task.name}
            note={task.goal.join(", ") || t("list.steps")}
            state={<Status mood={taskMood(task)} text={taskState(t, task)} />}
            current={current?.kind === "task" && current.id === task.name}
            open={() => open({ kind: "task", id: task.name })}
          />
        ))}
      </Stack>
    </ScrollArea>
  );
}

function SequenceList({ current, open }: ListProps) {
  const { t } = useTranslation("task");
  const { data, error, refetch } = useSequences();
  return (
    <>
      <NewSequenceButton title="" made={(id) => open({ kind: "sequence", id })} />
      {error !== null && <Problem error={error} again={refetch} />}
      {data?.length === 0 && <Text c="dimmed">{t("list.noSequences")}</Text>}
      <ScrollArea flex={1} mih={0}>
        <Stack gap={2}>
          {data?.map(({ id, title, count }) => (
            <Entry
              key={id}
              title={title || id}
              note={t("list.count", { count })}
              current={current?.kind === "sequence" && current.id === id}
              open={() => open({ kind: "sequence", id })}
            />
          ))}
        </Stack>
      </ScrollArea>
    </>
  );
}
