import { Alert, Button, Group, Modal, Stack, Text } from "@mantine/core";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, api, type Schema } from "../api/client";
import { keys } from "../api/keys";
import { useSingleMutation } from "../api/mutations";
import { queryClient } from "../api/queries";
import { MayButton } from "../widgets/MayButton";
import { problemText, problemTitle } from "../widgets/problems";
import { useDialogs } from "./dialogs";
import { useStopping } from "./stopping";
import { useHalt } from "./useHalt";
import { said } from "../i18n/sentences";

/** Resets the station after a person has confirmed that it is safe. */
export function ResetDialog() {
  const { t } = useTranslation("always");
  const { opened, close } = useDialogs();
  const halt = useHalt();
  return (
    <Modal opened={opened === "reset"} onClose={close} title={t("reset.title")} centered>
      {halt && <Question halt={halt} done={close} />}
    </Modal>
  );
}

/** Refers to the halt at the time of opening: a later one has not been inspected yet. */
function Question({ halt, done }: { halt: Schema<"StopInfo">; done: () => void }) {
  const { t } = useTranslation("always");
  const { t: common } = useTranslation();
  const [since] = useState(halt.since);
  const reset = useReset(done);
  const another = halt.halted && halt.since !== since;
  return (
    <Stack>
      <Text size="sm">{halt.halted ? t("reset.why", { why: said(halt.why) }) : t("reset.nothing")}</Text>
      {another ? <Alert color="red">{t("reset.another")}</Alert> : <Text size="sm">{t("reset.text")}</Text>}
      {reset.error && (
        <Alert role="alert" color="red" title={problemTitle(reset.error, t("reset.refused"))}>
          {problemText(reset.error)}
        </Alert>
      )}
      <Group justify="flex-end">
        <Button variant="default" onClick={done} data-autofocus>
          {common("cancel")}
        </Button>
        <MayButton
          operation="reset"
          color="red"
          disabled={!halt.halted || another}
          loading={reset.isPending}
          onClick={() => reset.mutate()}
        >
          {t("reset.confirm")}
        </MayButton>
      </Group>
    </Stack>
  );
}

function useReset(done: () => void) {
  return useSingleMutation({
    mutationFn: () => answer(api.POST("/api/v1/reset")),
    onSuccess: (halt) => {
      queryClient.setQueryData(keys.station("stop"), halt);
      useStopping.getState().forget();
      done();
    },
  });
}
