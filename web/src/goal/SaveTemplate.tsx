import { Alert, Button, Checkbox, Group, Modal, Stack, Text, Textarea, TextInput } from "@mantine/core";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { ApiProblem } from "../api/client";
import { useSingleMutation } from "../api/mutations";
import { queryClient } from "../api/queries";
import { problemText } from "../widgets/problems";
import { type CheckedCondition, type GoalData, shortText } from "./goals";
import {
  changeTemplate,
  type Content,
  isTemplateName,
  notifyTemplate,
  TEMPLATES,
  useTemplates,
  variablesOf,
  withPlaceholders,
} from "./templates";
import { useWords } from "./words";

interface Props {
  opened: boolean;
  onClose: () => void;
  conditions: readonly CheckedCondition[];
}

/** Saves the current conditions as a template, with a choice of its parameters. */
export function SaveTemplate({ opened, onClose, conditions }: Props) {
  const { t } = useTranslation("goal");
  return (
    <Modal opened={opened} onClose={onClose} title={t("template.save")}>
      <Form onDone={onClose} conditions={conditions} />
    </Modal>
  );
}

function Form({ onDone, conditions }: { onDone: () => void; conditions: readonly CheckedCondition[] }) {
  const { t } = useTranslation(["goal", "common"]);
  const { words } = useWords();
  const known = useTemplates();
  const [name, setName] = useState("");
  const [description, setDescription] = useState("");
  const [asked, setAsked] = useState<string[]>([]);
  const variables = variablesOf(conditions, words);
  const fits = isTemplateName(name);
  const there = known.find((template) => template.name === name.trim());
  const write = useSingleMutation({
    mutationFn: (content: Content) => changeTemplate(name.trim(), there ?? null, content),
    onSuccess: (undo) => {
      notifyTemplate(t("template.saved", { name: name.trim() }), undo);
      onDone();
    },
    onSettled: () => queryClient.invalidateQueries({ queryKey: TEMPLATES }),
  });
  const save = () => {
    const chosen = variables.filter(({ id }) => asked.includes(id));
    const parameters = chosen.map((one) => ({ name: one.name, class: one.class, default: one.id, description: "" }));
    const goal = conditions.map(({ data }) => withPlaceholders(data, chosen) as GoalData);
    write.mutate({ description, parameters, goal, per_material: null });
  };
  return (
    <Stack gap="sm">
      <TextInput
        label={t("template.name")}
        required
        maxLength={200}
        value={name}
        error={fits ? undefined : t("template.nameRule")}
        onChange={(event) => setName(event.currentTarget.value)}
        data-autofocus
      />
      <Textarea
        label={t("template.description")}
        maxLength={2000}
        value={description}
        onChange={(event) => setDescription(event.currentTarget.value)}
      />
      <div>
        {conditions.map(({ text }) => (
          <Text key={text} size="xs" c="dimmed">
            {shortText(text)}
          </Text>
        ))}
      </div>
      {variables.length > 0 && (
        <Checkbox.Group label={t("template.ask")} value={asked} onChange={setAsked}>
          <Stack gap={4} mt={4}>
            {variables.map(({ id, name: role }) => (
              <Checkbox key={id} value={id} label={t("template.askFor", { role, id })} size="xs" />
            ))}
          </Stack>
        </Checkbox.Group>
      )}
      {there && <Alert color="yellow">{t("template.there", { name: there.name })}</Alert>}
      {write.error && (
        <Alert color="red">
          {write.error instanceof ApiProblem && write.error.status === 412
            ? t("template.changed")
            : problemText(write.error)}
        </Alert>
      )}
      <Group>
        <Button onClick={save} disabled={!name.trim() || !fits} loading={write.isPending}>
          {there ? t("template.replace") : t("common:save")}
        </Button>
        <Button variant="default" onClick={onDone}>
          {t("common:cancel")}
        </Button>
      </Group>
    </Stack>
  );
}
