import { Group, Select } from "@mantine/core";
import { useDisclosure } from "@mantine/hooks";
import { useTranslation } from "react-i18next";
import { MayButton } from "../widgets/MayButton";
import type { Verdict } from "./checks";
import { useDraft } from "./draft";
import { SaveTemplate } from "./SaveTemplate";
import { useTemplates } from "./templates";

/** Opens a goal template, or saves the current conditions as one. */
export function TemplateChoice({ verdicts }: { verdicts: readonly Verdict[] }) {
  const { t } = useTranslation("goal");
  const { draft, change } = useDraft();
  const templates = useTemplates();
  const [saving, { open, close }] = useDisclosure();
  const conditions = verdicts.flatMap((verdict) => verdict.conditions);
  const ready = conditions.length > 0 && verdicts.every(({ state }) => state === "holds" || state === "open");
  return (
    <Group gap="xs" align="end">
      <Select
        flex={1}
        label={t("template.choose")}
        placeholder={templates.length === 0 ? t("template.none") : t("template.placeholder")}
        disabled={templates.length === 0}
        data={templates.map(({ name }) => name)}
        value={draft.template?.name ?? null}
        onChange={(name) => change({ template: name === null ? null : { name, parameters: {}, materials: [] } })}
        clearable
      />
      {draft.template === null && (
        <MayButton operation="put_document" variant="default" disabled={!ready} onClick={open}>
          {t("template.save")}
        </MayButton>
      )}
      <SaveTemplate opened={saving} onClose={close} conditions={conditions} />
    </Group>
  );
}
