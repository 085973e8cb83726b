import { Button, Group, Modal, Stack, Text } from "@mantine/core";
import { notifications } from "@mantine/notifications";
import { IconTrash } from "@tabler/icons-react";
import { useQuery } from "@tanstack/react-query";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, api, ApiProblem, type Schema } from "../../api/client";
import { keys } from "../../api/keys";
import { useSingleMutation } from "../../api/mutations";
import { queryClient } from "../../api/queries";
import { MayButton } from "../../widgets/MayButton";
import { notifyProblem } from "../../widgets/problems";
import { shown } from "../runs/changes";
import { nameOf } from "../../widgets/names";

type Lesson = Schema<"Learned">;

const MANY = 500;

/** The learned concepts, with a button to forget each. */
export function Learned() {
  const { t } = useTranslation("modules");
  const [doomed, setDoomed] = useState<Lesson | null>(null);
  const { data } = useQuery({
    queryKey: keys.world("learned"),
    queryFn: async () => (await answer(api.GET("/api/v1/learned", { params: { query: { limit: MANY } } }))).items,
  });
  if (data?.length === 0) return <Text size="sm">{t("learned.none")}</Text>;
  return (
    <>
      <Stack component="ul" gap="xs" m={0} p={0} style={{ listStyle: "none" }} aria-label={t("learned.title")}>
        {(data ?? []).map((lesson) => (
          <Entry key={lesson.id} lesson={lesson} forget={() => setDoomed(lesson)} />
        ))}
      </Stack>
      <Forget lesson={doomed} close={() => setDoomed(null)} />
    </>
  );
}

function Entry({ lesson, forget }: { lesson: Lesson; forget: () => void }) {
  const { t } = useTranslation("modules");
  return (
    <Group component="li" justify="space-between" wrap="nowrap" align="start">
      <div>
        <Text size="sm" fw={600}>
          {nameOf(lesson.id, lesson.label)}
        </Text>
        <Text size="xs" c="dimmed">
          {lesson.id} · {lesson.about ?? lesson.class}
        </Text>
        {Object.entries(lesson.properties).map(([name, value]) => (
          <Text key={name} size="xs">{`${name} = ${shown(value)}`}</Text>
        ))}
      </div>
      <MayButton
        operation="forget_learned"
        variant="default"
        leftSection={<IconTrash size={14} aria-hidden />}
        aria-label={t("learned.forgetOne", { label: lesson.label || lesson.id })}
        onClick={forget}
      >
        {t("learned.forget")}
      </MayButton>
    </Group>
  );
}

/** Asks for confirmation, then forgets the concept unless it was taught again meanwhile. */
function Forget({ lesson, close }: { lesson: Lesson | null; close: () => void }) {
  const { t } = useTranslation("modules");
  const forget = useSingleMutation({
    mutationFn: ({ id, version }: Lesson) =>
      answer(
        api.DELETE("/api/v1/learned/{element}", {
          params: { path: { element: id }, header: { "if-match": `"${version}"` } },
        }),
      ),
    onSuccess: (_, { label, id }) => notifications.show({ message: t("learned.forgotten", { label: label || id }) }),
    onError: (error) =>
      error instanceof ApiProblem && error.status === 412
        ? notifications.show({ color: "yellow", message: t("learned.changed") })
        : notifyProblem(error),
    onSettled: () => {
      close();
      void queryClient.invalidateQueries({ queryKey: keys.world("learned") });
    },
  });
  return (
    <Modal opened={lesson !== null} onClose={close} title={t("learned.sure")}>
      <Stack>
        <Text size="sm">{t("learned.sureText", { label: lesson?.label || lesson?.id })}</Text>
        <Group justify="end">
          <Button variant="default" onClick={close}>
            {t("learned.keep")}
          </Button>
          <Button color="red" loading={forget.isPending} onClick={() => lesson && forget.mutate(lesson)}>
            {t("learned.forget")}
          </Button>
        </Group>
      </Stack>
    </Modal>
  );
}
