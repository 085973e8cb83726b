import { Badge, Button, Group, List, Loader, Stack, Text, Timeline } from "@mantine/core";
import { IconPencil, IconRobot, IconServer, type TablerIcon } from "@tabler/icons-react";
import type { InfiniteData, UseInfiniteQueryResult } from "@tanstack/react-query";
import { useTranslation } from "react-i18next";
import type { Schema } from "../../api/client";
import { said } from "../../i18n/sentences";
import { Moment } from "../../widgets/Moment";
import { problemText } from "../../widgets/problems";
import { type Edit, editText, isAbout } from "../../widgets/edits";
import { nameNow } from "../../widgets/names";
import { UndoButton } from "./UndoButton";

type Change = Schema<"Change">;

const ICONS: Readonly<Record<string, TablerIcon>> = { person: IconPencil, skill: IconRobot, job: IconRobot };
const FEW = 8;

interface Props {
  query: UseInfiniteQueryResult<InfiniteData<Schema<"ChangePage">>>;
  /** Shows only the edits of this element. */
  about?: string;
}

/** Changes with author, reason and edits; the next one to undo has a button. */
export function ChangeList({ query, about }: Props) {
  const { t } = useTranslation("world");
  if (query.error) return <Text size="sm">{problemText(query.error)}</Text>;
  if (query.data === undefined) return <Loader size="sm" aria-label={t("changes.loading")} />;
  const changes = query.data.pages.flatMap((page) => page.items);
  if (changes.length === 0) return <Text size="sm">{t("changes.none")}</Text>;
  return (
    <Stack gap="xs" align="start">
      <Timeline bulletSize={20} lineWidth={1} aria-label={t("changes.label")}>
        {changes.map((change) => (
          <Timeline.Item key={change.number} bullet={<WriterIcon writer={change.writer} />}>
            <One change={change} about={about} />
          </Timeline.Item>
        ))}
      </Timeline>
      {query.hasNextPage && (
        <Button variant="default" loading={query.isFetchingNextPage} onClick={() => void query.fetchNextPage()}>
          {t("changes.more")}
        </Button>
      )}
    </Stack>
  );
}

function WriterIcon({ writer }: { writer: string }) {
  const Icon = ICONS[writer] ?? IconServer;
  return <Icon size={12} aria-hidden />;
}

function One({ change, about }: { change: Change; about: string | undefined }) {
  const { t } = useTranslation("world");
  const edits = (change.edits as unknown as Edit[]).filter((edit) => about === undefined || isAbout(edit, about));
  return (
    <Stack gap={2}>
      <Group gap={6}>
        <Text size="sm" fw={600}>
          {said(change.reason)}
        </Text>
        {change.undoes !== null && <Badge variant="default">{t("changes.undoes", { number: change.undoes })}</Badge>}
        <UndoButton only={change.number} />
      </Group>
      <Text size="xs" c="dimmed">
        {t("changes.by", change)} · {change.written ? <Moment at={change.written} /> : `${change.time.toFixed(1)} s`}
      </Text>
      <List size="xs" listStyleType="none" withPadding={false}>
        {edits.slice(0, FEW).map((edit, index) => (
          <List.Item key={index} style={{ overflowWrap: "anywhere" }}>
            {shortened(editLine(edit))}
          </List.Item>
        ))}
      </List>
      {about === undefined && change.edits_total > FEW && (
        <Text size="xs">{t("changes.furtherEdits", { count: change.edits_total - FEW })}</Text>
      )}
    </Stack>
  );
}

function editLine(edit: Edit): string {
  const { element, text } = editText(edit);
  return `${nameNow(element)} ${text}`;
}

function shortened(line: string): string {
  return line.length > 300 ? `${line.slice(0, 300)} …` : line;
}
