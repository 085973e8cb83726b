import { ActionIcon, Button, Group, Stack, Table, Text, Tooltip } from "@mantine/core";
import { IconDownload, IconTrash } from "@tabler/icons-react";
import { useQuery } from "@tanstack/react-query";
import { useTranslation } from "react-i18next";
import { answer, api, BASE, type Schema } from "../../api/client";
import { keys } from "../../api/keys";
import { useMay } from "../../api/session";
import { notifyChange } from "../../widgets/undo";
import { ClassLink } from "../ClassLink";
import { useWrite } from "../edit/useWrite";
import { useWords } from "../useWords";
import { written } from "../values";

type Learned = Schema<"Learned">;

const ALL = 1000;

/** The concepts that robots have learned, independent of the scene; forgetting can be undone. */
export function LearnedList() {
  const { t } = useTranslation("world");
  const { data } = useQuery({
    queryKey: keys.world("learned"),
    queryFn: async () => (await answer(api.GET("/api/v1/learned", { params: { query: { limit: ALL } } }))).items,
  });
  if (data === undefined) return null;
  if (data.length === 0) return <Text size="sm">{t("learned.none")}</Text>;
  return (
    <Stack gap="xs" align="start">
      <Table aria-label={t("learned.label")} verticalSpacing={4}>
        <Table.Tbody>
          {data.map((one) => (
            <Row key={one.id} learned={one} />
          ))}
        </Table.Tbody>
      </Table>
      <Button
        component="a"
        href={`${BASE}/api/v1/learned.ttl`}
        download="learned.ttl"
        variant="default"
        leftSection={<IconDownload size={14} aria-hidden />}
      >
        {t("learned.download")}
      </Button>
    </Stack>
  );
}

function Row({ learned }: { learned: Learned }) {
  const words = useWords();
  return (
    <Table.Tr>
      <Table.Th scope="row">
        {learned.label}
        <Text size="xs" c="dimmed">
          {learned.id}
        </Text>
      </Table.Th>
      <Table.Td>
        <ClassLink name={learned.class} />
        {learned.about && (
          <>
            {" → "}
            <ClassLink name={learned.about} />
          </>
        )}
      </Table.Td>
      <Table.Td>
        {Object.entries(learned.properties).map(([name, value]) => (
          <Text key={name} size="xs">
            {name}: {written(value, words)}
          </Text>
        ))}
      </Table.Td>
      <Table.Td>
        <Forget learned={learned} />
      </Table.Td>
    </Table.Tr>
  );
}

function Forget({ learned: { id, label, version } }: { learned: Learned }) {
  const { t } = useTranslation("world");
  const may = useMay("forget_learned");
  const forget = useWrite(
    () =>
      answer(
        api.DELETE("/api/v1/learned/{element}", {
          params: { path: { element: id }, header: { "if-match": `"${version}"` } },
        }),
      ),
    ({ change }) => notifyChange(t("learned.forgotten", { label }), change?.number),
  );
  const what = t("learned.forget", { label });
  if (!may) return null;
  return (
    <Group justify="end">
      <Tooltip label={what}>
        <ActionIcon aria-label={what} loading={forget.isPending} onClick={() => forget.mutate()}>
          <IconTrash size={15} />
        </ActionIcon>
      </Tooltip>
    </Group>
  );
}
