import { Alert, Button, Group, Modal, Stack, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { answer, answerWithTag, api } from "../api/client";
import { useSingleMutation } from "../api/mutations";
import { queryClient } from "../api/queries";
import { MayButton } from "../widgets/MayButton";
import { problemText, problemTitle } from "../widgets/problems";
import { useDialogs } from "./dialogs";

/** Loads another scene after confirmation, since it replaces the current one. */
export function LoadSceneDialog() {
  const { t } = useTranslation("always");
  const { opened, about, close } = useDialogs();
  return (
    <Modal opened={opened === "load"} onClose={close} title={t("load.title", { name: about })} centered>
      <Question name={about} done={close} />
    </Modal>
  );
}

function Question({ name, done }: { name: string; done: () => void }) {
  const { t } = useTranslation("always");
  const { t: common } = useTranslation();
  const load = useSingleMutation({
    mutationFn: async () => {
      const { tag } = await answerWithTag(api.GET("/api/v1/scene"));
      return answer(api.PUT("/api/v1/scene", { params: { header: { "if-match": tag } }, body: { name } }));
    },
    onSuccess: () => {
      void queryClient.invalidateQueries();
      done();
    },
  });
  return (
    <Stack>
      <Text size="sm">{t("load.text")}</Text>
      {load.error && (
        <Alert role="alert" color="red" title={problemTitle(load.error)}>
          {problemText(load.error)}
        </Alert>
      )}
      <Group justify="flex-end">
        <Button variant="default" onClick={done}>
          {common("cancel")}
        </Button>
        <MayButton operation="load_scene" loading={load.isPending} onClick={() => load.mutate()} data-autofocus>
          {t("load.confirm")}
        </MayButton>
      </Group>
    </Stack>
  );
}
