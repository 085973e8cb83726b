import { Button, Group, Stack, Text, TextInput } from "@mantine/core";
import { IconDeviceFloppy, IconDownload, IconFileDiff } from "@tabler/icons-react";
import { type SyntheticEvent, useState } from "react";
import { useTranslation } from "react-i18next";
import { BASE, type Schema } from "../../api/client";
import { MayButton } from "../../widgets/MayButton";
import { Status } from "../../widgets/Status";
import { Difference } from "./Difference";
import { usePresent } from "./queries";
import { ReplaceDialog } from "./ReplaceDialog";
import { useSave } from "./useSave";

/** The current scene: its facts, whether it is saved, and saving it. */
export function Present() {
  const { data } = usePresent();
  if (data === undefined) return null;
  return (
    <Stack gap="xs">
      <Facts scene={data.data} />
      <SaveAs key={data.data.name} scene={data.data} />
    </Stack>
  );
}

function Facts({ scene }: { scene: Schema<"CurrentScene"> }) {
  const { t } = useTranslation(["world", "common"]);
  const [compared, setCompared] = useState(false);
  return (
    <>
      <Group gap="xs">
        <Text fw={600}>{scene.name || t("scenes.unnamed")}</Text>
        <Saved changed={scene.changed} />
      </Group>
      <Text size="sm">
        {t("scenes.facts", {
          count: scene.elements,
          robots: scene.robots.map((robot) => robot.id).join(", ") || t("value.none"),
          version: scene.version,
        })}
      </Text>
      <Group gap={6}>
        <Button
          component="a"
          href={`${BASE}/api/v1/scene.ttl`}
          download={`${scene.name || "scene"}.ttl`}
          variant="default"
          leftSection={<IconDownload size={14} aria-hidden />}
        >
          {t("scenes.download")}
        </Button>
        {scene.name && (
          <Button
            variant="default"
            leftSection={<IconFileDiff size={14} aria-hidden />}
            aria-expanded={compared}
            onClick={() => setCompared(!compared)}
          >
            {t("scenes.compare", { name: scene.name })}
          </Button>
        )}
      </Group>
      {compared && <Difference name={scene.name} />}
    </>
  );
}

function Saved({ changed }: { changed: boolean | null }) {
  const { t } = useTranslation(["world", "common"]);
  if (changed === null) return <Status mood="warning" text={t("scenes.nowhere")} />;
  return changed ? (
    <Status mood="warning" text={t("scenes.changed")} />
  ) : (
    <Status mood="good" text={t("scenes.unchanged")} />
  );
}

const NAME = /^[a-z0-9][a-z0-9_-]{0,63}$/;

function SaveAs({ scene }: { scene: Schema<"CurrentScene"> }) {
  const { t } = useTranslation(["world", "common"]);
  const [name, setName] = useState(scene.name);
  const saving = useSave();
  const right = NAME.test(name);
  const submit = (event: SyntheticEvent) => {
    event.preventDefault();
    if (right) saving.save(name);
  };
  return (
    <form onSubmit={submit} aria-label={t("scenes.save")}>
      <Group gap={6} align="end">
        <TextInput
          label={t("scenes.saveAs")}
          value={name}
          onChange={(event) => setName(event.currentTarget.value)}
          error={name !== "" && !right ? t("scenes.nameRule") : saving.refusal}
        />
        <MayButton
          operation="save_scene"
          type="submit"
          disabled={!right}
          loading={saving.busy}
          leftSection={<IconDeviceFloppy size={14} aria-hidden />}
        >
          {t("common:save")}
        </MayButton>
      </Group>
      {saving.asked && <ReplaceDialog name={name} onReplace={saving.replace} onClose={saving.close} />}
    </form>
  );
}
