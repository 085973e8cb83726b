import { Badge, Button, Group, Paper, Select, Stack, Text, Title } from "@mantine/core";
import { useDebouncedValue } from "@mantine/hooks";
import { IconArrowLeft } from "@tabler/icons-react";
import { useMemo } from "react";
import { useTranslation } from "react-i18next";
import { said } from "../../i18n/sentences";
import { argumentFaults, type Arguments, ArgumentsForm } from "../../widgets/ArgumentsForm";
import { useDraft } from "../drafts";
import classes from "../modules.module.css";
import type { View } from "../places";
import { type Summary, useModule, usePanel } from "../queries";
import { shown } from "../runs/changes";
import { RunsOf } from "../runs/RunsOf";
import { ConditionPanel } from "./ConditionPanel";
import { Description } from "./Description";
import { RunBar } from "./RunBar";

interface Props {
  module: Summary;
  agent: string;
  choose: (module: string, agent: string) => void;
  back: () => void;
  show: (view: View, ...rest: string[]) => void;
}

const PAUSE = 250; // ms without typing before the conditions are checked again

/** One module of one subsystem: form, conditions, run commands and past runs. */
export function ModulePage({ module, agent, choose, back, show }: Props) {
  const { t } = useTranslation("modules");
  const { data: details } = useModule(agent, module.name);
  const [draft, change] = useDraft(agent, module.name);
  const [asked] = useDebouncedValue(draft.values, PAUSE);
  const parameters = useMemo(() => details?.parameters ?? [], [details]);
  const sound = Object.keys(argumentFaults(parameters, draft.values)).length === 0;
  const panel = usePanel(agent, module.name, asked);
  const notes = useNotes(panel.data, asked);
  return (
    <Stack gap="sm">
      <Heading module={module} agent={agent} choose={choose} back={back} />
      <div className={classes.panels}>
        <Paper withBorder p="sm" component="section" aria-label={t("arguments")}>
          <ArgumentsForm
            parameters={parameters}
            value={draft.values}
            onChange={(values) => change({ values })}
            notes={notes}
          />
        </Paper>
        <ConditionPanel panel={panel.data} problem={panel.error} waiting={panel.isFetching} />
      </div>
      <RunBar agent={agent} module={module.name} draft={draft} change={change} sound={sound} />
      <RunsOf agent={agent} module={module.name} show={show} />
      {details && <Description details={details} />}
    </Stack>
  );
}

/** For each field, the value that would be inferred, or the reason why none is. */
function useNotes(panel: ReturnType<typeof usePanel>["data"], given: Arguments): Record<string, string> {
  const { t } = useTranslation("modules");
  return useMemo(() => {
    const notes: Record<string, string> = {};
    for (const [key, value] of Object.entries(panel?.arguments ?? {})) {
      if (value !== null && !(key in given)) notes[key] = t("panel.taken", { value: shown(value) });
    }
    for (const [key, why] of Object.entries(panel?.inferred ?? {})) {
      notes[key] = t("panel.inferredAs", { value: shown(panel?.arguments[key]), why: said(why) });
    }
    for (const [key, why] of Object.entries(panel?.missing ?? {})) notes[key] = t("panel.open", { why: said(why) });
    return notes;
  }, [panel, given, t]);
}

function Heading({ module, agent, choose, back }: Omit<Props, "show">) {
  const { t } = useTranslation("modules");
  return (
    <div>
      <Group gap="xs">
        <Button
          className={classes.back}
          variant="subtle"
          size="compact-xs"
          leftSection={<IconArrowLeft size={14} aria-hidden />}
          onClick={back}
        >
          {t("list.back")}
        </Button>
        <Title order={2} size="h4">
          {module.name}
        </Title>
        <Badge variant="default" tt="none">
          {t(`kind.${module.kind}`)} {module.version}
        </Badge>
        {module.agents.length > 1 ? (
          <Select
            aria-label={t("agent")}
            w="10rem"
            allowDeselect={false}
            data={module.agents.map((place) => place.agent)}
            value={agent}
            onChange={(who) => who !== null && choose(module.name, who)}
          />
        ) : (
          <Text size="sm" c="dimmed">
            {agent}
          </Text>
        )}
      </Group>
      <Text size="sm">{said(module.help)}</Text>
    </div>
  );
}
