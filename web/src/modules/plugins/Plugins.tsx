import { Alert, Code, Stack, Table, Text, TextInput } from "@mantine/core";
import { IconSearch } from "@tabler/icons-react";
import { useQuery } from "@tanstack/react-query";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { answer, api, type Schema } from "../../api/client";
import { keys } from "../../api/keys";
import { Status } from "../../widgets/Status";

/** The installed plug-ins, broken ones first. */
export function Plugins() {
  const { t } = useTranslation("modules");
  const { data } = useQuery({
    queryKey: keys.station("plugins"),
    queryFn: () => answer(api.GET("/api/v1/plugins")),
  });
  const faults = [...(data?.others ?? []), ...(data?.items ?? []).flatMap((item) => item.faults)];
  return (
    <Stack gap="sm" p="sm">
      {data && faults.length === 0 && <Status mood="good" text={t("plugins.allWork", { count: data.items.length })} />}
      {faults.map((fault) => (
        <Fault key={`${fault.group} ${fault.name} ${fault.reason}`} fault={fault} />
      ))}
      {data && <Installed items={data.items} />}
    </Stack>
  );
}

function Fault({ fault }: { fault: Schema<"PluginFaultInfo"> }) {
  const { t } = useTranslation("modules");
  return (
    <Alert color="red" title={`${fault.name} (${fault.group}, ${fault.distribution})`}>
      <Text size="sm">{fault.reason}</Text>
      {fault.origin && <Text size="xs">{fault.origin}</Text>}
      {fault.traceback && (
        <details>
          <summary>{t("plugins.traceback")}</summary>
          <Code block>{fault.traceback}</Code>
        </details>
      )}
    </Alert>
  );
}

function Installed({ items }: { items: Schema<"PluginInfo">[] }) {
  const { t } = useTranslation("modules");
  const [text, setText] = useState("");
  const fits = (item: Schema<"PluginInfo">) =>
    `${item.name} ${item.group} ${item.distribution}`.toLowerCase().includes(text.toLowerCase());
  return (
    <>
      <TextInput
        aria-label={t("plugins.search")}
        placeholder={t("plugins.search")}
        leftSection={<IconSearch size={14} aria-hidden />}
        value={text}
        onChange={(event) => setText(event.currentTarget.value)}
      />
      <Table.ScrollContainer minWidth={420}>
        <Table verticalSpacing={2} fz="xs" aria-label={t("views.plugins")}>
          <Table.Thead>
            <Table.Tr>
              <Table.Th>{t("plugins.name")}</Table.Th>
              <Table.Th>{t("plugins.group")}</Table.Th>
              <Table.Th>{t("plugins.distribution")}</Table.Th>
              <Table.Th>{t("plugins.state")}</Table.Th>
            </Table.Tr>
          </Table.Thead>
          <Table.Tbody>
            {items.filter(fits).map((item) => (
              <Table.Tr key={`${item.group} ${item.name}`}>
                <Table.Td title={item.object}>{item.name}</Table.Td>
                <Table.Td>{item.group}</Table.Td>
                <Table.Td>{`${item.distribution} ${item.version}`}</Table.Td>
                <Table.Td>
                  <Status
                    mood={item.works ? "good" : "bad"}
                    text={t(item.works ? "plugins.works" : "plugins.broken")}
                  />
                </Table.Td>
              </Table.Tr>
            ))}
          </Table.Tbody>
        </Table>
      </Table.ScrollContainer>
    </>
  );
}
