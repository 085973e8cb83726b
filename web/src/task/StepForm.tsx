import { Button, Group, Select, Stack, Text } from "@mantine/core";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { said } from "../i18n/sentences";
import { argumentFaults, type Arguments, ArgumentsForm } from "../widgets/ArgumentsForm";
import type { Schema } from "../api/client";
import type { Skills } from "../api/cell";
import type { WantedStep } from "./sequences";
import { byName } from "../widgets/names";

interface Props {
  skills: Skills;
  /** The edited step; undefined for a new one. */
  step?: WantedStep;
  label: string;
  pending: boolean;
  save: (step: WantedStep) => void;
  cancel: () => void;
}

type Skill = Schema<"SkillInfo">;

/** A step: robot, skill, and its arguments. */
export function StepForm({ skills, step, label, pending, save, cancel }: Props) {
  const { t } = useTranslation("task");
  const { t: common } = useTranslation();
  const robots = robotsOf(skills);
  const [robot, setRobot] = useState(() => robotOf(skills, step) ?? robots[0] ?? null);
  const [name, setName] = useState<string | null>(step?.skill ?? null);
  const [values, setValues] = useState<Arguments>(() => given(skills, step));
  const skill = name === null ? undefined : skills.get(name);
  const offered = [...skills.values()].filter((one) => agentFor(one, robot) !== undefined);
  const choose = (next: string | null) => {
    setName(next);
    setValues(next === null ? {} : forRobot(skills.get(next), robot));
  };
  const wrong = skill !== undefined && Object.keys(argumentFaults(skill.parameters, values)).length > 0;
  return (
    <Stack gap="xs" component="form" aria-label={label} onSubmit={(event) => submit(event)}>
      <Group grow gap="xs" align="start">
        <Select
          label={t("step.robot")}
          data={robots}
          value={robot}
          allowDeselect={false}
          onChange={(value) => {
            setRobot(value);
            setName(null);
          }}
        />
        <Select
          label={t("step.skill")}
          placeholder={t("step.choose")}
          data={offered.map((one) => one.name)}
          value={name}
          allowDeselect={false}
          searchable
          onChange={choose}
        />
      </Group>
      {skill !== undefined && (
        <>
          <Text size="sm">{said(skill.help)}</Text>
          <ArgumentsForm parameters={skill.parameters} value={values} onChange={setValues} />
        </>
      )}
      <Group justify="end" gap="xs">
        <Button variant="default" onClick={cancel}>
          {common("cancel")}
        </Button>
        <Button type="submit" disabled={skill === undefined || wrong} loading={pending}>
          {label}
        </Button>
      </Group>
    </Stack>
  );

  function submit(event: { preventDefault: () => void }) {
    event.preventDefault();
    if (skill !== undefined && !wrong) save({ skill: skill.name, arguments: texts(values) });
  }
}

function robotsOf(skills: Skills): string[] {
  return [...new Set([...skills.values()].flatMap(({ agents }) => agents.map(({ robot }) => robot)))].sort(byName);
}

function agentFor(skill: Skill, robot: string | null): string | undefined {
  return skill.agents.find((agent) => agent.robot === robot)?.agent;
}

function robotOf(skills: Skills, step: WantedStep | undefined): string | undefined {
  const skill = step && skills.get(step.skill);
  if (skill === undefined) return undefined;
  const agent = step?.arguments?.[skill.agent];
  return (skill.agents.find((one) => one.agent === agent) ?? skill.agents[0])?.robot;
}

/** The subsystem follows from the chosen robot. */
function forRobot(skill: Skill | undefined, robot: string | null): Arguments {
  const agent = skill && agentFor(skill, robot);
  return skill === undefined || agent === undefined ? {} : { [skill.agent]: agent };
}

/** The given arguments of a step, without those inferred for planning, which are inferred again. */
function given(skills: Skills, step: WantedStep | undefined): Arguments {
  const parameters = (step && skills.get(step.skill)?.parameters) ?? [];
  const inferred = new Set(parameters.filter(({ planning }) => planning).map(({ key }) => key));
  return Object.fromEntries(Object.entries(step?.arguments ?? {}).filter(([key]) => !inferred.has(key)));
}

function texts(values: Arguments): Record<string, string> {
  const given = Object.entries(values).filter(([, value]) => value !== undefined && value !== null && value !== "");
  return Object.fromEntries(
    given.map(([key, value]) => [key, typeof value === "string" ? value : JSON.stringify(value)]),
  );
}
