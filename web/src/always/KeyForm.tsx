import { Alert, Button, PasswordInput, Stack, Text } from "@mantine/core";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, api, ApiProblem } from "../api/client";
import { keys } from "../api/keys";
import { useSingleMutation } from "../api/mutations";
import { queryClient } from "../api/queries";
import { emitReset } from "../live/events";
import { problemText } from "../widgets/problems";
import { useStopping } from "./stopping";

/** Exchanges a key for a cookie that scripts cannot read. */
export function KeyForm() {
  const { t } = useTranslation("always");
  const [key, setKey] = useState("");
  const login = useSingleMutation({
    mutationFn: () => answer(api.POST("/api/v1/session", { body: { key: key.trim() } })),
    onSuccess: (me) => {
      queryClient.setQueryData(keys.me, me);
      useStopping.getState().signedIn();
      void queryClient.invalidateQueries({ predicate: ({ queryKey }) => queryKey[0] !== keys.me[0] });
      emitReset(); // reloads data kept outside of the queries, such as the tree
    },
  });
  return (
    <form
      onSubmit={(event) => {
        event.preventDefault();
        login.mutate();
      }}
    >
      <Stack>
        <PasswordInput
          label={t("login.key")}
          description={t("login.keyHint")}
          autoComplete="current-password"
          value={key}
          onChange={(event) => setKey(event.currentTarget.value)}
          data-autofocus
          required
          withAsterisk={false}
        />
        {login.error && (
          <Alert role="alert" color="red" title={t("login.refused")}>
            {refusalText(login.error, t("login.wrong"), t("login.tooMany"))}
          </Alert>
        )}
        <Button type="submit" size="sm" loading={login.isPending} disabled={key.trim() === ""}>
          {t("login.enter")}
        </Button>
        <Text size="xs" c="dimmed">
          {t("login.where")} <code>skiros key create</code>
        </Text>
      </Stack>
    </form>
  );
}

function refusalText(error: unknown, wrong: string, tooMany: string): string {
  const status = error instanceof ApiProblem ? error.status : 0;
  if (status === 401) return wrong;
  return status === 429 ? tooMany : problemText(error);
}
