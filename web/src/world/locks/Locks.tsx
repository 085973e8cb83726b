import { Button, Table, Text } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { answer, api, type Schema } from "../../api/client";
import { useMe } from "../../api/session";
import { ElementName } from "../../widgets/ElementName";
import { useWrite } from "../edit/useWrite";
import { useLocks } from "./locks";

/** The locks; users can end their own, admins all. */
export function Locks() {
  const { t } = useTranslation("world");
  const { data } = useLocks();
  const { data: me } = useMe();
  if (data === undefined || data.length === 0) return <Text size="sm">{t("locks.none")}</Text>;
  return (
    <Table aria-label={t("locks.label")} verticalSpacing={4}>
      <Table.Tbody>
        {data.map((lock) => (
          <Row key={lock.element} lock={lock} may={me?.role === "admin" || lock.owner === me?.name} />
        ))}
      </Table.Tbody>
    </Table>
  );
}

function Row({ lock, may }: { lock: Schema<"Lock">; may: boolean }) {
  const { t } = useTranslation("world");
  const query = { elements: [lock.element], owner: lock.owner };
  const end = useWrite(() => answer(api.DELETE("/api/v1/locks", { params: { query } })));
  return (
    <Table.Tr>
      <Table.Td>
        <ElementName id={lock.element} />
      </Table.Td>
      <Table.Td>{t("locks.by", { owner: lock.owner })}</Table.Td>
      <Table.Td>{t("locks.seconds", { seconds: Math.round(lock.seconds) })}</Table.Td>
      <Table.Td>
        {may && (
          <Button variant="default" loading={end.isPending} onClick={() => end.mutate()}>
            {t("locks.end")}
          </Button>
        )}
      </Table.Td>
    </Table.Tr>
  );
}
