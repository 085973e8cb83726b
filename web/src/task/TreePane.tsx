import { Box, SegmentedControl, Stack, Text } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, api } from "../api/client";
import { keys } from "../api/keys";
import { Graph, type GraphNode } from "../widgets/Graph";
import { moduleStatus } from "./moduleWords";
import { useOutput } from "./output";
import type { Skills } from "../api/cell";
import { schedule, type Slot } from "./schedule";
import type { Run, Step } from "./trace";
import { messagesOf, type StateTexts, skillTree, taskTree, wayOf } from "./tree";
import { STEP_MOODS, stepState, stepTitle } from "./words";

interface Props {
  run: Run;
  skills: Skills;
  title: string;
  state: GraphNode["state"] & object;
  /** Explains why the tree is empty. */
  nothing: string;
  chosen: string | null;
  choose: (step: string) => void;
}

/** The live tree of a task: its steps, or the nodes of the selected (otherwise running) step. */
export default function TreePane({ run, skills, title, state, nothing, chosen, choose }: Props) {
  const { t } = useTranslation("task");
  const [shown, show] = useState<"task" | "skill">("task");
  const present = run.plans.at(-1);
  const slots = present === undefined ? [] : schedule(present, run.steps, skills, 0);
  const step = run.steps.find(({ key }) => key === chosen) ?? run.steps.at(-1);
  const texts: StateTexts = { step: (one) => t(`stepStates.${one}`), module: (status) => moduleStatus(t, status) };
  if (slots.length === 0 && run.steps.length === 0) return <Text c="dimmed">{nothing}</Text>;
  return (
    <Stack gap="xs" h="100%">
      <SegmentedControl
        size="xs"
        aria-label={t("tree.shows")}
        value={shown}
        onChange={(value) => show(value as "task" | "skill")}
        data={[
          { value: "task", label: t("tree.steps") },
          {
            value: "skill",
            label: step === undefined ? t("tree.skill") : stepTitle(step, skills),
            disabled: step === undefined,
          },
        ]}
      />
      <Box h="max(280px, 45vh)">
        {shown === "skill" && step !== undefined ? (
          <SkillGraph step={step} run={run} skills={skills} texts={texts} />
        ) : (
          <TaskGraph
            run={run}
            slots={slots}
            skills={skills}
            texts={texts}
            title={title}
            state={state}
            chosen={chosen}
            choose={choose}
          />
        )}
      </Box>
    </Stack>
  );
}

interface TaskProps extends Omit<Props, "run" | "nothing"> {
  run: Run;
  slots: readonly Slot[];
  texts: StateTexts;
}

function TaskGraph({ run, slots, skills, texts, title, state, chosen, choose }: TaskProps) {
  const { t } = useTranslation("task");
  const planned = new Set(slots.flatMap((slot) => slot.runs));
  const others = run.steps.filter((step) => !planned.has(step));
  const { nodes, edges } = taskTree({ title, state, slots, others }, skills, texts);
  const ids = new Map<string, string>([
    ...slots.flatMap((slot): [string, string][] => slot.runs.map((step) => [step.key, `step ${slot.index}`])),
    ...others.map((step): [string, string] => [step.key, `ran ${step.key}`]),
  ]);
  const chooseNode = (id: string) => {
    const key = [...ids].findLast(([, node]) => node === id)?.[0];
    if (key !== undefined && key !== chosen) choose(key);
  };
  const node = chosen === null ? null : (ids.get(chosen) ?? null);
  return <Graph label={t("tree.label")} nodes={nodes} edges={edges} chosen={node} onChoose={chooseNode} />;
}

function SkillGraph({ step, run, skills, texts }: { step: Step; run: Run; skills: Skills; texts: StateTexts }) {
  const { t } = useTranslation("task");
  const { data } = useModule(step.agent, step.skill);
  const rows = useOutput(({ rows: all }) => all);
  const state = stepState(step);
  const root = {
    id: "skill",
    title: stepTitle(step, skills),
    state: { mood: STEP_MOODS[state], text: texts.step(state) },
  };
  const [way, messages] = wayOf(step, data?.implementations ?? [], messagesOf(step, rows, run.shift));
  const { nodes, edges } = skillTree(root, step.skill, way, messages, texts);
  return <Graph label={t("tree.skillLabel", { skill: root.title })} nodes={nodes} edges={edges} />;
}

function useModule(agent: string, module: string) {
  return useQuery({
    queryKey: keys.modules("details", agent, module),
    queryFn: () => answer(api.GET("/api/v1/modules/{agent}/{module}", { params: { path: { agent, module } } })),
    retry: false,
  });
}
