import { Alert, Button, Group, Modal, Stack, Text } from "@mantine/core";
import { useQueryClient } from "@tanstack/react-query";
import { useTranslation } from "react-i18next";
import { answer, api } from "../../api/client";
import { useSingleMutation } from "../../api/mutations";
import { useWorks } from "../../live/station";
import { useSelection } from "../../selection/selection";
import { problemText, problemTitle } from "../../widgets/problems";
import { notifyDone } from "../../widgets/toasts";
import { Difference } from "./Difference";
import { usePresent } from "./queries";

/** A scene by name, or the text of an uploaded file. */
export interface SceneToLoad {
  name: string;
  text?: string;
}

/** Media types of scenes, by the ends of file names. */
export const MEDIA_TYPES: Record<string, string> = {
  ".ttl": "text/turtle",
  ".owl": "application/rdf+xml",
  ".rdf": "application/rdf+xml",
  ".owx": "application/owl+xml",
  ".xml": "application/rdf+xml",
  ".nt": "application/n-triples",
  ".jsonld": "application/ld+json",
};

interface Props {
  scene: SceneToLoad;
  onClose: () => void;
}

/** Asks for confirmation before another scene is loaded; lists the unsaved changes that would be lost. */
export function LoadDialog({ scene, onClose }: Props) {
  const { t } = useTranslation(["world", "common"]);
  const { data: present } = usePresent();
  const load = useLoad(scene, onClose);
  const works = useWorks();
  if (present === undefined) return null;
  const { name, changed } = present.data;
  return (
    <Modal opened onClose={onClose} title={t("load.title", { name: scene.name })} size="lg">
      <Stack>
        <Text size="sm">{t("load.text")}</Text>
        {works && <Alert color="orange">{t("load.works")}</Alert>}
        {changed === null && <Alert color="orange">{t("load.neverSaved")}</Alert>}
        {changed && (
          <Alert color="orange" title={t("load.lost")}>
            <Difference name={name} />
          </Alert>
        )}
        {load.error && (
          <Alert color="red" title={problemTitle(load.error, t("load.refused"))} style={{ whiteSpace: "pre-wrap" }}>
            {problemText(load.error)}
          </Alert>
        )}
        <Group justify="end">
          <Button variant="default" onClick={onClose} data-autofocus>
            {t("common:cancel")}
          </Button>
          <Button
            color={changed ? "red" : undefined}
            disabled={works}
            loading={load.isPending}
            onClick={() => load.mutate(present.tag)}
          >
            {changed ? t("load.anyway") : t("scenes.load")}
          </Button>
        </Group>
      </Stack>
    </Modal>
  );
}

function useLoad(scene: SceneToLoad, onDone: () => void) {
  const { t } = useTranslation(["world", "common"]);
  const client = useQueryClient();
  return useSingleMutation({
    mutationFn: (tag: string) => {
      useSelection.getState().choose(null); // not at the end: an element of the new scene may be selected by then
      return put(scene, tag);
    },
    onSuccess: () => {
      void client.invalidateQueries(); // robots, modules and goals change as well
      notifyDone(t("load.done", { name: scene.name }));
      onDone();
    },
  });
}

function put({ name, text }: SceneToLoad, tag: string) {
  const params = { header: { "if-match": tag } };
  if (text === undefined) return answer(api.PUT("/api/v1/scene", { params, body: { name } }));
  const type = MEDIA_TYPES[name.slice(name.lastIndexOf("."))] ?? "text/turtle";
  return answer(
    api.PUT("/api/v1/scene", {
      params: { header: { ...params.header, "Content-Type": type } },
      body: text as never, // the generated types take only the first media type
      bodySerializer: String,
    }),
  );
}
