import { Alert, Group, List, Paper, Stack, Text, Title } from "@mantine/core";
import { IconAlertTriangle, IconCheck, IconQuestionMark, IconX } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import type { Schema } from "../../api/client";
import { useMay } from "../../api/session";
import { useStation } from "../../live/station";
import { problemText } from "../../widgets/problems";
import { Status } from "../../widgets/Status";
import { ServerText } from "../../goal/ServerText";
import { filled } from "../../task/StepDetails";

interface Props {
  panel: Schema<"PanelInfo"> | undefined;
  problem: Error | null;
  waiting: boolean;
}

const KINDS = ["pre", "hold", "post"] as const;

/** Whether a module could run now, and whether each of its conditions holds, with the reason. */
export function ConditionPanel({ panel, problem, waiting }: Props) {
  const { t } = useTranslation("modules");
  const may = useMay("show_panel");
  return (
    <Paper withBorder p="sm" component="section" aria-label={t("panel.label")} aria-busy={waiting}>
      <Stack gap="xs">
        <Group justify="space-between">
          <Title order={3} size="h6">
            {t("panel.label")}
          </Title>
          {panel && !problem && <Readiness ready={panel.ready} />}
        </Group>
        {!may && <Text size="sm">{t("panel.mayNot")}</Text>}
        {problem ? (
          <Alert color="red" icon={<IconAlertTriangle aria-hidden />} title={t("panel.refused")}>
            {problemText(problem)}
          </Alert>
        ) : (
          panel && <Findings panel={panel} />
        )}
      </Stack>
    </Paper>
  );
}

/** Whether it could run now: nothing can while everything is halted, regardless of conditions. */
function Readiness({ ready }: { ready: boolean }) {
  const { t } = useTranslation("modules");
  const halted = useStation(({ state }) => Boolean(state?.halted));
  if (halted) return <Status mood="stopped" text={t("panel.halted")} />;
  return <Status mood={ready ? "good" : "bad"} text={t(ready ? "panel.ready" : "panel.notReady")} />;
}

function Findings({ panel }: { panel: Schema<"PanelInfo"> }) {
  const { t } = useTranslation("modules");
  const missing = Object.entries(panel.missing);
  return (
    <>
      {missing.length > 0 && (
        <div>
          <Text size="xs" fw={600}>
            {t("panel.missing")}
          </Text>
          <List size="xs" spacing={2}>
            {missing.map(([key, why]) => (
              <List.Item key={key}>{why.startsWith(`${key}:`) ? why : `${key}: ${why}`}</List.Item>
            ))}
          </List>
        </div>
      )}
      {panel.conditions.length === 0 && <Text size="xs">{t("panel.none")}</Text>}
      {KINDS.map((kind) => (
        <Rows
          key={kind}
          kind={kind}
          rows={panel.conditions.filter((row) => row.kind === kind)}
          inputs={panel.arguments}
        />
      ))}
    </>
  );
}

type Inputs = Schema<"PanelInfo">["arguments"];

interface RowsProps {
  kind: (typeof KINDS)[number];
  rows: Schema<"PanelRow">[];
  inputs: Inputs;
}

function Rows({ kind, rows, inputs }: RowsProps) {
  const { t } = useTranslation("modules");
  if (rows.length === 0) return null;
  return (
    <div>
      <Text size="xs" fw={600} id={`panel-${kind}`}>
        {t(`panel.${kind}`)}
      </Text>
      <Stack gap={2} component="ul" m={0} p={0} aria-labelledby={`panel-${kind}`} style={{ listStyle: "none" }}>
        {rows.map((row) => (
          <Row key={row.condition} row={row} inputs={inputs} />
        ))}
      </Stack>
    </div>
  );
}

const MARKS = {
  yes: { icon: IconCheck, color: "green" },
  no: { icon: IconX, color: "red" },
  open: { icon: IconQuestionMark, color: "gray" },
  later: { icon: IconX, color: "gray" },
} as const;

/** One condition; a postcondition that does not hold yet is not an error. */
function Row({ row, inputs }: { row: Schema<"PanelRow">; inputs: Inputs }) {
  const { t } = useTranslation("modules");
  const verdict = row.holds === null ? "open" : row.holds ? "yes" : row.kind === "post" ? "later" : "no";
  const { icon: Icon, color } = MARKS[verdict];
  return (
    <Group component="li" gap={6} wrap="nowrap" align="start">
      <Icon
        size={16}
        color={`var(--mantine-color-${color}-text)`}
        role="img"
        aria-label={t(`panel.verdict.${verdict}`)}
        style={{ flexShrink: 0 }}
      />
      <div>
        <Text size="xs">
          <ServerText text={filled(row.condition, inputs)} />{" "}
          <Text span inherit c="dimmed">{`(${t(`panel.verdict.${verdict}`)})`}</Text>
        </Text>
        {row.why.map((line) => (
          <Text key={line} size="xs" c="dimmed">
            <ServerText text={line} />
          </Text>
        ))}
      </div>
    </Group>
  );
}
