import { Divider, Stack, Tabs, Text } from "@mantine/core";
import { IconBinaryTree, IconFileText, IconTerminal2, IconTimeline } from "@tabler/icons-react";
import { lazy, type ReactNode, useEffect, useState } from "react";
import { useTranslation } from "react-i18next";
import { Part } from "../app/Part";
import type { GraphNode } from "../widgets/Graph";
import { followOutput } from "./output";
import { OutputPane } from "./OutputPane";
import type { Skills } from "../api/cell";
import { StepDetails } from "./StepDetails";
import { Timeline } from "./Timeline";
import type { Run } from "./trace";

interface Props {
  /** Id of the job, or name of the task. */
  name: string;
  run: Run;
  skills: Skills;
  title: string;
  state: GraphNode["state"] & object;
  paused: boolean;
  /** Start and end [ms since 1970]; null if not known (yet). */
  from: number | null;
  to: number | null;
  report: ReactNode;
  /** Explains why nothing was planned or executed. */
  nothing: string;
  /** Key of the selected step. */
  chosen: string | null;
  choose: (step: string | null) => void;
}

const TreePane = lazy(() => import("./TreePane"));

const ICONS = { timeline: IconTimeline, tree: IconBinaryTree, output: IconTerminal2, report: IconFileText };
type Pane = keyof typeof ICONS;
const PANES = Object.keys(ICONS) as Pane[];

/** A run in its four panes, with the selected step. */
export function RunPanes({ name, run, skills, title, state, paused, from, to, report, ...rest }: Props) {
  const { chosen, choose } = rest;
  const { t } = useTranslation("task");
  const [pane, setPane] = useState<Pane>("timeline");
  useEffect(followOutput, []);
  const step = run.steps.find(({ key }) => key === chosen);
  const contents: Record<Pane, ReactNode> = {
    timeline: <Timeline run={run} skills={skills} paused={paused} name={name} {...rest} />,
    tree: <TreePane run={run} skills={skills} title={title} state={state} {...rest} />,
    output: <OutputPane name={name} from={from} to={to} />,
    report,
  };
  return (
    <Stack gap="xs">
      <Tabs value={pane} onChange={(value) => setPane(value as Pane)} keepMounted={false}>
        <Tabs.List aria-label={t("panes.label")}>
          {PANES.map((one) => {
            const Icon = ICONS[one];
            return (
              <Tabs.Tab key={one} value={one} px="xs" leftSection={<Icon size={14} aria-hidden />}>
                {t(`panes.${one}`)}
              </Tabs.Tab>
            );
          })}
        </Tabs.List>
        <Tabs.Panel value={pane} pt="xs">
          <Part key={pane}>{contents[pane]}</Part>
        </Tabs.Panel>
      </Tabs>
      <Divider />
      {step === undefined ? (
        run.steps.length > 0 && (
          <Text size="sm" c="dimmed">
            {t("details.choose")}
          </Text>
        )
      ) : (
        <StepDetails name={name} step={step} run={run} skills={skills} close={() => choose(null)} />
      )}
    </Stack>
  );
}
