import { Alert, Stack, Table, Text } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { useEffect } from "react";
import { useTranslation } from "react-i18next";
import { answer, api } from "../api/client";
import { keys } from "../api/keys";
import { ElementPicker } from "../widgets/ElementPicker";
import type { Verdict as Check } from "./checks";
import { useDraft } from "./draft";
import { keyed, type Row } from "./goals";
import { usePlaces } from "./pieces";
import type { ConditionWord } from "./sentence";
import { Verdict } from "./Verdict";

/** The condition that puts an object into a place, and the one whose second argument is a kit. */
const PUT = "ObjectAtLocation";
const KIT = "InKit";

interface Props {
  words: readonly ConditionWord[];
  verdicts: readonly Check[];
}

/** A kit's bill of parts: the part for each of its places. It shows the same conditions as a table. */
export function KitTable({ words, verdicts }: Props) {
  const { t } = useTranslation("goal");
  const { draft, change } = useDraft();
  const put = words.find(({ name }) => name === PUT);
  const kitClass =
    words.find(({ name }) => name === KIT)?.roles[1]?.reached ?? put?.roles[1]?.reached ?? "sk:Container";
  const placeClass = put?.roles[1]?.reached ?? "sk:Container";
  useOnlyKit(kitClass);
  const places = usePlaces(draft.kit, placeClass).data ?? [];
  if (put === undefined) return <Alert color="yellow">{t("kit.cannot")}</Alert>;
  return (
    <Stack gap="xs">
      <ElementPicker
        label={t("kit.which")}
        class_={kitClass}
        value={draft.kit}
        onChange={(kit) => change({ kit })}
        required
      />
      {draft.kit !== null && (
        <Table aria-label={t("kit.table")} withTableBorder verticalSpacing={4}>
          <Table.Thead>
            <Table.Tr>
              <Table.Th>{t("kit.place")}</Table.Th>
              <Table.Th>{t("kit.part")}</Table.Th>
            </Table.Tr>
          </Table.Thead>
          <Table.Tbody>
            {places.map(({ id, name }) => {
              const index = draft.rows.findIndex((row) => puts(row, id));
              const row = draft.rows[index];
              return (
                <Table.Tr key={id}>
                  <Table.Th scope="row" fw={400}>
                    {name}
                  </Table.Th>
                  <Table.Td>
                    <ElementPicker
                      label={t("kit.partIn", { place: name })}
                      hideLabel
                      class_={put.roles[0]?.reached ?? "sk:Element"}
                      abstract
                      value={row?.kind === "word" ? (row.arguments[0] ?? null) : null}
                      onChange={(part) => change((now) => ({ rows: withPart(now.rows, id, part) }))}
                    />
                    {row && <Verdict verdict={verdicts[index] ?? { state: "asking", why: "", conditions: [] }} />}
                  </Table.Td>
                </Table.Tr>
              );
            })}
          </Table.Tbody>
        </Table>
      )}
      <Text size="xs" c="dimmed">
        {t("kit.help")}
      </Text>
    </Stack>
  );
}

/** Selects the kit if there is only one. */
function useOnlyKit(kitClass: string): void {
  const { draft, change } = useDraft();
  const { data } = useQuery({
    queryKey: keys.world("kits", kitClass),
    queryFn: () => answer(api.GET("/api/v1/elements", { params: { query: { class: kitClass, limit: 2 } } })),
    enabled: draft.kit === null,
  });
  const only = data?.items.length === 1 ? data.items[0]?.id : undefined;
  useEffect(() => {
    if (only !== undefined && draft.kit === null) change({ kit: only });
  });
}

/** Whether a row defines the part for a place. */
function puts(row: Row, place: string): boolean {
  return row.kind === "word" && row.word === PUT && !row.not && row.arguments[1] === place;
}

/** The rows with another part for a place; null for none. */
export function withPart(rows: readonly Row[], place: string, part: string | null): Row[] {
  if (part === null) return rows.filter((row) => !puts(row, place));
  const put = { kind: "word", word: PUT, arguments: [part, place], not: false } as const;
  if (!rows.some((row) => puts(row, place))) return [...rows, ...keyed([{ ...put, arguments: [part, place] }])];
  return rows.map((row) => (puts(row, place) ? { ...put, arguments: [part, place], key: row.key } : row));
}
