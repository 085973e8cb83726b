import { ActionIcon, Alert, Button, Group, Stack, Text, TextInput, Title, Tooltip } from "@mantine/core";
import { IconArrowBackUp, IconTrash } from "@tabler/icons-react";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { useSingleMutation } from "../api/mutations";
import { queryClient } from "../api/queries";
import { useMay } from "../api/session";
import { ConfirmDialog } from "../widgets/ConfirmDialog";
import { ElementPicker } from "../widgets/ElementPicker";
import { localName, useClassLabels } from "../widgets/names";
import { notifyProblem } from "../widgets/problems";
import { ConditionText } from "./ConditionText";
import type { Verdict as Check } from "./checks";
import { type Filled, useDraft } from "./draft";
import classes from "./goal.module.css";
import { rowOf, whyAlone } from "./goals";
import { Materials } from "./Materials";
import { changeTemplate, classOf, notifyTemplate, type Template, TEMPLATES } from "./templates";
import { Verdict } from "./Verdict";
import { useWords } from "./words";

interface Props {
  template: Template;
  filled: Filled;
  verdict: Check;
}

/** The form of a goal template: parameters by type, and the parts as a table. */
export function TemplateForm({ template, filled, verdict }: Props) {
  const { t } = useTranslation("goal");
  const { change, setRows } = useDraft();
  const { words } = useWords();
  const labels = useClassLabels();
  const fullName = (class_: string) => [...labels.keys()].find((name) => name === class_ || localName(name) === class_);
  const { content } = template;
  const fill = (part: Partial<Filled>) => change({ template: { ...filled, ...part } });
  const give = (name: string, value: string | null) =>
    fill({ parameters: { ...filled.parameters, [name]: value ?? "" } });
  return (
    <Stack gap="xs" component="section" aria-label={t("template.one", { name: template.name })}>
      <Group justify="space-between">
        <Title order={3} size="h5">
          {t("template.one", { name: template.name })}
        </Title>
        <Group gap={4}>
          <RemoveTemplate template={template} />
          <Button
            variant="default"
            leftSection={<IconArrowBackUp size={14} aria-hidden />}
            onClick={() => change({ template: null })}
          >
            {t("template.leave")}
          </Button>
        </Group>
      </Group>
      {content.description && <Text size="sm">{content.description}</Text>}
      {content.parameters.map((parameter) => {
        const class_ = fullName(parameter.class) ?? classOf(content, { parameter: parameter.name }, words);
        const common = {
          label: parameter.name,
          description: parameter.description || undefined,
          required: !parameter.default,
        };
        const value = filled.parameters[parameter.name] || parameter.default || "";
        return class_ ? (
          <ElementPicker
            key={parameter.name}
            {...common}
            class_={class_}
            value={value || null}
            onChange={(id) => give(parameter.name, id)}
          />
        ) : (
          <TextInput
            key={parameter.name}
            {...common}
            value={value}
            onChange={(event) => give(parameter.name, event.currentTarget.value)}
          />
        );
      })}
      {content.per_material && (
        <Materials
          content={content}
          filled={filled}
          words={words}
          onChange={(materials) => fill({ materials: [...materials] })}
        />
      )}
      {verdict.state === "wrong" ? (
        <Alert color="red">{verdict.why}</Alert>
      ) : (
        <ul className={classes.rows} aria-label={t("conditions")}>
          {verdict.conditions.map((condition) => (
            <li key={condition.text} className={classes.row} aria-label={condition.text}>
              <ConditionText condition={condition} />
              <Verdict
                verdict={{
                  state: condition.holds ? "holds" : "open",
                  why: whyAlone(condition),
                  conditions: [condition],
                }}
              />
            </li>
          ))}
        </ul>
      )}
      {verdict.conditions.length > 0 && (
        <Group>
          <Button variant="default" onClick={() => setRows(verdict.conditions.map(rowOf))}>
            {t("template.dissolve")}
          </Button>
        </Group>
      )}
    </Stack>
  );
}

function RemoveTemplate({ template }: { template: Template }) {
  const { t } = useTranslation(["goal", "common"]);
  const { change } = useDraft();
  const may = useMay("remove_document");
  const [asking, setAsking] = useState(false);
  const remove = useSingleMutation({
    mutationFn: () => changeTemplate(template.name, template, null),
    onSuccess: (undo) => {
      change({ template: null });
      notifyTemplate(t("template.removed", { name: template.name }), undo);
    },
    onError: notifyProblem,
    onSettled: () => queryClient.invalidateQueries({ queryKey: TEMPLATES }),
  });
  if (!may) return null;
  return (
    <>
      <Tooltip label={t("template.remove")}>
        <ActionIcon
          color="red"
          aria-label={t("template.remove")}
          loading={remove.isPending}
          onClick={() => setAsking(true)}
        >
          <IconTrash size={16} aria-hidden />
        </ActionIcon>
      </Tooltip>
      {asking && (
        <ConfirmDialog
          title={t("template.removeTitle", { name: template.name })}
          text={t("template.removeText")}
          action={t("common:remove")}
          onConfirm={() => remove.mutate()}
          onClose={() => setAsking(false)}
        />
      )}
    </>
  );
}
