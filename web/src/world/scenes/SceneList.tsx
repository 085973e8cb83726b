import { ActionIcon, Badge, FileButton, Group, Stack, Table, Text, Tooltip } from "@mantine/core";
import { IconTrash, IconUpload } from "@tabler/icons-react";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, answerWithTag, api, type Schema } from "../../api/client";
import { useMay } from "../../api/session";
import { MayButton } from "../../widgets/MayButton";
import { Moment } from "../../widgets/Moment";
import { useWrite } from "../edit/useWrite";
import { ConfirmDialog } from "../../widgets/ConfirmDialog";
import { LoadDialog, MEDIA_TYPES, type SceneToLoad } from "./LoadDialog";
import { usePresent, useScenes } from "./queries";

/** The scenes that can be loaded. */
export function SceneList() {
  const { t } = useTranslation("world");
  const { data: scenes } = useScenes();
  const { data: present } = usePresent();
  const [loading, setLoading] = useState<SceneToLoad | null>(null);
  const upload = (file: File | null) => {
    if (file) void file.text().then((text) => setLoading({ name: file.name, text }));
  };
  return (
    <Stack gap="xs" align="start">
      <Table aria-label={t("scenes.list")} verticalSpacing={4}>
        <Table.Tbody>
          {scenes?.map((scene) => (
            <Row
              key={`${scene.source} ${scene.name}`}
              scene={scene}
              present={scene.name === present?.data.name}
              onLoad={() => setLoading({ name: scene.name })}
            />
          ))}
        </Table.Tbody>
      </Table>
      <FileButton onChange={upload} accept={Object.keys(MEDIA_TYPES).join()}>
        {(props) => (
          <MayButton
            operation="load_scene"
            variant="default"
            leftSection={<IconUpload size={14} aria-hidden />}
            {...props}
          >
            {t("scenes.upload")}
          </MayButton>
        )}
      </FileButton>
      {loading && <LoadDialog scene={loading} onClose={() => setLoading(null)} />}
    </Stack>
  );
}

interface RowProps {
  scene: Schema<"SceneEntry">;
  present: boolean;
  onLoad: () => void;
}

function Row({ scene, present, onLoad }: RowProps) {
  const { t } = useTranslation("world");
  return (
    <Table.Tr>
      <Table.Th scope="row">
        <Group gap={6}>
          {scene.name}
          {present && <Badge variant="light">{t("scenes.present")}</Badge>}
        </Group>
      </Table.Th>
      <Table.Td>
        <Text size="xs">
          {scene.source === "installed" ? t("scenes.installed") : t("scenes.savedAt")} <Moment at={scene.saved} />
        </Text>
      </Table.Td>
      <Table.Td>
        <Group gap={4} justify="end" wrap="nowrap">
          <MayButton
            operation="load_scene"
            variant="default"
            aria-label={t("scenes.loadOne", { name: scene.name })}
            onClick={onLoad}
          >
            {t("scenes.load")}
          </MayButton>
          {scene.source === "saved" && <Delete name={scene.name} />}
        </Group>
      </Table.Td>
    </Table.Tr>
  );
}

function Delete({ name }: { name: string }) {
  const { t } = useTranslation("world");
  const may = useMay("delete_scene");
  const [asked, setAsked] = useState(false);
  const remove = useWrite(() => deleteScene(name));
  const label = t("scenes.deleteOne", { name });
  if (!may) return null;
  return (
    <>
      <Tooltip label={label}>
        <ActionIcon aria-label={label} onClick={() => setAsked(true)}>
          <IconTrash size={15} />
        </ActionIcon>
      </Tooltip>
      {asked && (
        <ConfirmDialog
          title={label}
          text={t("scenes.deleteText")}
          action={t("scenes.delete")}
          onConfirm={() => remove.mutate()}
          onClose={() => setAsked(false)}
        />
      )}
    </>
  );
}

async function deleteScene(name: string) {
  const path = { name };
  const { tag } = await answerWithTag(api.GET("/api/v1/scenes/{name}", { params: { path } }));
  return answer(api.DELETE("/api/v1/scenes/{name}", { params: { path, header: { "if-match": tag } } }));
}
