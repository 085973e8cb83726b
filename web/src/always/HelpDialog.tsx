import { Group, Kbd, Modal, Table } from "@mantine/core";
import { useTranslation } from "react-i18next";
import { useDialogs } from "./dialogs";
import { SHORTCUTS } from "./shortcuts";

/** The list of keys. */
export function HelpDialog() {
  const { t } = useTranslation("always");
  const { opened, close } = useDialogs();
  return (
    <Modal opened={opened === "help"} onClose={close} title={t("help.title")} centered>
      <Table aria-label={t("help.title")}>
        <Table.Tbody>
          {SHORTCUTS.map(([name, keys]) => (
            <Table.Tr key={name}>
              <Table.Td>
                <Group gap={4} wrap="nowrap">
                  {keys.map((key) => (
                    <Kbd key={key}>{key}</Kbd>
                  ))}
                </Group>
              </Table.Td>
              <Table.Td>{t(`help.${name}`)}</Table.Td>
            </Table.Tr>
          ))}
        </Table.Tbody>
      </Table>
    </Modal>
  );
}
