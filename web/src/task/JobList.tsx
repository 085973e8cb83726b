import { Group, Select, Text, TextInput } from "@mantine/core";
import { useVirtualizer } from "@tanstack/react-virtual";
import { useRef, useState } from "react";
import { useTranslation } from "react-i18next";
import type { Schema } from "../api/client";
import { GoalText } from "../goal/GoalText";
import { Moment } from "../widgets/Moment";
import { Status } from "../widgets/Status";
import { Entry } from "./Entry";
import { type Period, PERIODS, useJobs } from "./jobs";
import { jobState } from "./jobWords";
import type { ListProps } from "./Lists";
import { Problem } from "./Problem";
import classes from "./task.module.css";
import { jobMood } from "./words";

const HEIGHT = 52; // px
type Kind = "every" | "open" | "good" | "bad";
const KINDS: Kind[] = ["every", "open", "good", "bad"];

/** The jobs of a period, latest first. */
export function JobList({ current, open }: ListProps) {
  const { t } = useTranslation("task");
  const [period, setPeriod] = useState<Period>("week");
  const [kind, setKind] = useState<Kind>("every");
  const [text, setText] = useState("");
  const { data, error, refetch } = useJobs(period);
  const jobs = (data ?? []).filter((job) => isOf(job, kind) && matches(job, text.trim().toLowerCase()));
  return (
    <div className={classes.list}>
      <TextInput
        aria-label={t("list.filter")}
        placeholder={t("list.filter")}
        value={text}
        onChange={(event) => setText(event.currentTarget.value)}
      />
      <Group grow gap={4} wrap="nowrap">
        <Select
          aria-label={t("list.state")}
          data={KINDS.map((value) => ({ value, label: t(`list.kinds.${value}`) }))}
          value={kind}
          allowDeselect={false}
          onChange={(value) => setKind(value as Kind)}
        />
        <Select
          aria-label={t("list.period")}
          data={Object.keys(PERIODS).map((value) => ({ value, label: t(`list.periods.${value as Period}`) }))}
          value={period}
          allowDeselect={false}
          onChange={(value) => setPeriod(value as Period)}
        />
      </Group>
      {error !== null && <Problem error={error} again={refetch} />}
      {jobs.length === 0 && data !== undefined && <Text c="dimmed">{t("list.noJobs")}</Text>}
      <Jobs jobs={jobs} current={current} open={open} />
    </div>
  );
}

interface JobsProps extends ListProps {
  jobs: readonly Schema<"Job">[];
}

function Jobs({ jobs, current, open }: JobsProps) {
  const { t } = useTranslation("task");
  const scrolled = useRef<HTMLDivElement>(null);
  // The virtualizer returns functions that cannot be memoized; nothing here is.
  // eslint-disable-next-line react-hooks/incompatible-library
  const virtual = useVirtualizer({
    count: jobs.length,
    getScrollElement: () => scrolled.current,
    estimateSize: () => HEIGHT,
    overscan: 10,
  });
  return (
    <div ref={scrolled} style={{ flex: 1, minHeight: 80, overflow: "auto" }}>
      <ul
        aria-label={t("list.jobs")}
        style={{ height: virtual.getTotalSize(), position: "relative", margin: 0, padding: 0 }}
      >
        {virtual.getVirtualItems().map(({ index, start }) => {
          const job = jobs[index];
          if (job === undefined) return null;
          return (
            <li
              key={job.id}
              style={{ position: "absolute", top: start, insetInline: 0, height: HEIGHT, listStyle: "none" }}
            >
              <Entry
                title={job.order.description || <GoalText goal={job.order.goal} plain />}
                note={<JobNote job={job} />}
                state={<Status mood={jobMood(job)} text={jobState(t, job)} />}
                current={current?.kind === "job" && current.id === job.id}
                open={() => open({ kind: "job", id: job.id })}
              />
            </li>
          );
        })}
      </ul>
    </div>
  );
}

function JobNote({ job }: { job: Schema<"Job"> }) {
  return (
    <>
      <Moment at={job[momentOf(job)]} /> · {job.id}
    </>
  );
}

/** Its last state. */
function momentOf({ ended, started }: Schema<"Job">): "ended" | "started" | "ordered" {
  if (ended !== null) return "ended";
  return started !== null ? "started" : "ordered";
}

function isOf(job: Schema<"Job">, kind: Kind): boolean {
  if (kind === "every") return true;
  if (kind === "open") return job.ended === null;
  return job.ended !== null && (jobMood(job) === "good") === (kind === "good");
}

function matches(job: Schema<"Job">, wanted: string): boolean {
  const { id, order, outcome, state } = job;
  const all = [id, order.description, ...order.goal, order.work_master, outcome ?? "", state.text].join(" ");
  return wanted === "" || all.toLowerCase().includes(wanted);
}
