import { Alert, Group, Loader, Stack, Tabs, Text, Title } from "@mantine/core";
import { useState } from "react";
import { useTranslation } from "react-i18next";
import { isGone } from "../../api/client";
import { useSelection } from "../../selection/selection";
import { problemText } from "../../widgets/problems";
import { ClassLink } from "../ClassLink";
import { EditForm } from "../edit/EditForm";
import { LockedBy } from "../locks/LockedBy";
import { type Tagged, useElement } from "../queries";
import { Actions } from "./Actions";
import { Connections } from "./Connections";
import { Gone } from "./Gone";
import { History } from "./History";
import { Properties } from "./Properties";
import { Whereabouts } from "./Whereabouts";

/** The details of the selected element, and the actions on it. */
export function ElementDetails() {
  const { t } = useTranslation("world");
  const selected = useSelection((selection) => selection.selected);
  const { data, error } = useElement(selected);
  if (selected === null) {
    return (
      <Text c="dimmed" size="sm" p="xs">
        {t("details.nothing")}
      </Text>
    );
  }
  if (isGone(error)) return <Gone id={selected} />;
  if (data === undefined && !error) return <Loader size="sm" aria-label={t("details.loading")} />;
  return (
    <>
      {error && <Alert color="red">{problemText(error)}</Alert>}
      {data && <Element key={selected} tagged={data} />}
    </>
  );
}

function Element({ tagged }: { tagged: Tagged }) {
  const [editing, setEditing] = useState(false);
  const element = tagged.data;
  return (
    <Stack component="section" gap="xs" aria-label={element.label}>
      <Head tagged={tagged} />
      {editing ? (
        <EditForm tagged={tagged} onDone={() => setEditing(false)} />
      ) : (
        <>
          <Actions tagged={tagged} onEdit={() => setEditing(true)} />
          <Parts tagged={tagged} />
        </>
      )}
    </Stack>
  );
}

function Head({ tagged: { data } }: { tagged: Tagged }) {
  const { t } = useTranslation("world");
  return (
    <div>
      <Group gap="xs" align="baseline">
        <Title order={3} size="h5" style={{ overflowWrap: "anywhere" }}>
          {data.label}
        </Title>
        <Text size="xs" c="dimmed">
          {data.id}
        </Text>
        <LockedBy element={data.id} />
      </Group>
      <Group gap="xs">
        <ClassLink name={data.class} />
        <Text size="xs" c="dimmed">
          {t("details.version", { version: data.version })}
        </Text>
        {data.abstract && (
          <Text size="xs" fs="italic">
            {t("details.abstract")}
          </Text>
        )}
      </Group>
    </div>
  );
}

function Parts({ tagged }: { tagged: Tagged }) {
  const { t } = useTranslation("world");
  const element = tagged.data;
  return (
    <>
      <Whereabouts element={element} />
      <Tabs defaultValue="properties" keepMounted={false}>
        <Tabs.List aria-label={t("details.parts")}>
          <Tabs.Tab value="properties">{t("details.properties")}</Tabs.Tab>
          <Tabs.Tab value="relations">{t("details.relations", { count: element.relations_total })}</Tabs.Tab>
          <Tabs.Tab value="history">{t("details.history")}</Tabs.Tab>
        </Tabs.List>
        <Tabs.Panel value="properties" pt="xs">
          <Properties element={element} />
        </Tabs.Panel>
        <Tabs.Panel value="relations" pt="xs">
          <Connections tagged={tagged} />
        </Tabs.Panel>
        <Tabs.Panel value="history" pt="xs">
          <History element={element.id} />
        </Tabs.Panel>
      </Tabs>
    </>
  );
}
