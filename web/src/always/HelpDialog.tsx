import { Group, Kbd, Modal, Table, Title } from "@mantine/core";
import { useId } from "react";
import { useTranslation } from "react-i18next";
import { useDialogs } from "./dialogs";
import { SHORTCUTS } from "./shortcuts";

const PLACES = Object.keys(SHORTCUTS) as (keyof typeof SHORTCUTS)[];

/** The list of keys. */
export function HelpDialog() {
  const { t } = useTranslation("always");
  const { opened, close } = useDialogs();
  return (
    <Modal opened={opened === "help"} onClose={close} title={t("help.title")} size="lg" centered>
      {PLACES.map((place) => (
        <Keys key={place} place={place} />
      ))}
    </Modal>
  );
}

/** The keys of one part of the page. */
function Keys({ place }: { place: keyof typeof SHORTCUTS }) {
  const { t } = useTranslation("always");
  const title = useId();
  return (
    <>
      <Title order={3} size="sm" mt="sm" id={title}>
        {t(`help.places.${place}`)}
      </Title>
      <Table aria-labelledby={title} layout="fixed">
        <Table.Tbody>
          {SHORTCUTS[place].map(([name, keys]) => (
            <Table.Tr key={name}>
              <Table.Td w="40%">
                <Group gap={4} wrap="nowrap">
                  {keys.map((key, i) => (
                    <Kbd key={i}>{key}</Kbd>
                  ))}
                </Group>
              </Table.Td>
              <Table.Td>{t(`help.${name}`)}</Table.Td>
            </Table.Tr>
          ))}
        </Table.Tbody>
      </Table>
    </>
  );
}
