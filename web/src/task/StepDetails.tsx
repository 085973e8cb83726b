import { Badge, Button, CloseButton, Group, Stack, Table, Text, Title } from "@mantine/core";
import { useQueries } from "@tanstack/react-query";
import { useTranslation } from "react-i18next";
import { answer, api, type Schema } from "../api/client";
import { useReplay } from "../scene3d/replay";
import { ElementName } from "../widgets/ElementName";
import { problemText } from "../widgets/problems";
import { Status } from "../widgets/Status";
import { editText } from "../widgets/edits";
import { useOutput } from "./output";
import { OutputTable } from "./OutputTable";
import type { Skills } from "../api/cell";
import { Section } from "./Section";
import type { ConditionRow, Run, Step } from "./trace";
import { messagesOf } from "./tree";
import { span, STEP_MOODS, stepState, stepTitle } from "./words";
import { ServerText } from "../goal/ServerText";
import { shown } from "../modules/runs/changes";

interface Props {
  /** Id of the job, or name of the task. */
  name: string;
  step: Step;
  run: Run;
  skills: Skills;
  close: () => void;
}

/** Everything about one step: inputs, conditions, changes of the world, messages. */
export function StepDetails({ name, step, run, skills, close }: Props) {
  const { t } = useTranslation("task");
  const title = stepTitle(step, skills);
  return (
    <Stack gap="xs" component="section" aria-label={t("details.label", { title })}>
      <Group gap="xs" wrap="nowrap" align="start" justify="space-between">
        <Group gap="xs">
          <Title order={4} size="h5">
            {title}
          </Title>
          <Status mood={STEP_MOODS[stepState(step)]} text={t(`stepStates.${stepState(step)}`)} />
          <Text size="sm" c="dimmed">
            {`${(step.start - run.begun).toFixed(1)} s${step.end === null ? " …" : ` + ${span(step.end - step.start)}`}`}
          </Text>
          <ReplayFrom name={name} step={step} />
        </Group>
        <CloseButton aria-label={t("details.close")} onClick={close} />
      </Group>
      {step.ended !== "ended" && (
        <Text size="sm">
          <ServerText text={step.text} />
        </Text>
      )}
      <Section title={t("details.inputs")}>
        <Inputs values={step.inputs} parameters={skills.get(step.skill)?.parameters ?? []} />
      </Section>
      <Section title={t("details.conditions")}>
        <Conditions rows={step.conditions} inputs={step.inputs} running={step.end === null} />
      </Section>
      <Section title={t("details.changes")}>
        <Changes numbers={step.changes} />
      </Section>
      <Section title={t("details.logs")}>
        <Logs step={step} shift={run.shift} />
      </Section>
    </Stack>
  );
}

/** In a replay: jumps to the start of the step. */
function ReplayFrom({ name, step }: { name: string; step: Step }) {
  const { t } = useTranslation("task");
  const shown = useReplay(({ replay }) => replay?.job === name);
  if (!shown) return null;
  return (
    <Button variant="light" size="compact-xs" onClick={() => useReplay.getState().set({ time: step.start })}>
      {t("replay.here")}
    </Button>
  );
}

interface InputsProps {
  values: Record<string, unknown>;
  parameters: readonly Schema<"ModuleParameter">[];
}

function Inputs({ values, parameters }: InputsProps) {
  const elements = new Set(parameters.filter(({ json_schema }) => "class" in json_schema).map(({ key }) => key));
  return (
    <Table verticalSpacing={1} withRowBorders={false} w="auto">
      <Table.Tbody>
        {Object.entries(values).map(([key, value]) => (
          <Table.Tr key={key}>
            <Table.Th scope="row" fw={500}>
              {key}
            </Table.Th>
            <Table.Td>
              {typeof value === "string" && elements.has(key) ? <ElementName id={value} /> : shown(value)}
            </Table.Td>
          </Table.Tr>
        ))}
      </Table.Tbody>
    </Table>
  );
}

const KINDS: readonly string[] = ["pre", "hold", "post"];

function isKind(kind: string): kind is "pre" | "hold" | "post" {
  return KINDS.includes(kind);
}

/** A condition of a skill about the arguments of a step: "Holding(Gripper, Object)" with their ids. */
export function filled(condition: string, inputs: Step["inputs"]): string {
  return condition.replaceAll(/(?<=[(,]\s*)\w+(?=\s*[,)])/g, (key) => String(inputs[key] ?? key));
}

interface ConditionsProps {
  rows: readonly ConditionRow[];
  inputs: Step["inputs"];
  running: boolean;
}

function Conditions({ rows, inputs, running }: ConditionsProps) {
  const { t } = useTranslation("task");
  if (rows.length === 0) return <Text c="dimmed">{t(running ? "details.later" : "details.noConditions")}</Text>;
  return (
    <Table verticalSpacing={2}>
      <Table.Tbody>
        {rows.map((row, index) => (
          // They have no id, and their order never changes.
          <Table.Tr key={`${row.kind} ${row.condition} ${index}`}>
            <Table.Td w={80}>
              <Badge variant="default" tt="none">
                {isKind(row.kind) ? t(`details.kinds.${row.kind}`) : row.kind}
              </Badge>
            </Table.Td>
            <Table.Td>
              <ServerText text={filled(row.condition, inputs)} />
            </Table.Td>
            <Table.Td>
              <Holds holds={row.holds} />
              {row.why.map((why) => (
                <Text key={why} size="sm">
                  <ServerText text={why} />
                </Text>
              ))}
            </Table.Td>
          </Table.Tr>
        ))}
      </Table.Tbody>
    </Table>
  );
}

function Holds({ holds }: { holds: boolean | null }) {
  const { t } = useTranslation("task");
  if (holds === null) return <Status mood="waiting" text={t("details.open")} />;
  return holds ? <Status mood="good" text={t("details.holds")} /> : <Status mood="bad" text={t("details.holdsNot")} />;
}

function Changes({ numbers }: { numbers: readonly number[] }) {
  const { t } = useTranslation("task");
  const changes = useQueries({
    queries: numbers.map((number) => ({
      queryKey: ["changes", number], // recorded changes are immutable
      queryFn: () => answer(api.GET("/api/v1/world/changes/{number}", { params: { path: { number } } })),
    })),
  });
  if (numbers.length === 0) return <Text c="dimmed">{t("details.noChanges")}</Text>;
  return (
    <Stack gap={2} component="ul" m={0} pl="md">
      {changes.map(({ data, error }, index) => {
        if (error) return <li key={numbers[index]}>{problemText(error)}</li>;
        return data?.edits.map((edit, place) => <Edit key={`${data.number} ${place}`} edit={edit} />);
      })}
    </Stack>
  );
}

function Edit({ edit }: { edit: Schema<"Change">["edits"][number] }) {
  const { element, text } = editText(edit);
  return (
    <li>
      {element !== "" && <ElementName id={element} />}
      {` ${text}`}
    </li>
  );
}

function Logs({ step, shift }: { step: Step; shift: number }) {
  const { t } = useTranslation("task");
  const rows = useOutput(({ rows: all }) => all);
  const own = messagesOf(step, rows, shift);
  if (own.length === 0) return <Text c="dimmed">{t("details.noLogs")}</Text>;
  return <OutputTable rows={own} label={t("details.logs")} height={Math.min(220, 34 + 26 * own.length)} />;
}
