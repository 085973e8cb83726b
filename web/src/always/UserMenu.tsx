import { Button, Popover, Stack, Text } from "@mantine/core";
import { IconLogout, IconUser } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { useMe } from "../api/session";
import { logout } from "./logout";

/** The user, the permissions of their role, and the logout button. */
export function UserMenu() {
  const { t } = useTranslation("always");
  const { data: me } = useMe();
  if (me === undefined) return null;
  const role = t(`roles.${me.role}.name`);
  return (
    <Popover width={300} position="bottom-end" withArrow shadow="md" trapFocus>
      <Popover.Target>
        <Button
          variant="subtle"
          color="gray"
          leftSection={<IconUser size={16} aria-hidden />}
          aria-label={t("user.open", { name: me.name, role })}
        >
          {me.name} · {role}
        </Button>
      </Popover.Target>
      <Popover.Dropdown aria-label={t("user.title")}>
        <Stack gap="xs">
          <Text size="sm" fw={600}>
            {me.name} · {role}
          </Text>
          <Text size="sm">{t(`roles.${me.role}.may`)}</Text>
          {!me.keys_needed && (
            <Text size="xs" c="dimmed">
              {t("user.openDoor")}
            </Text>
          )}
          {me.keys_needed && (
            <Button variant="default" leftSection={<IconLogout size={16} aria-hidden />} onClick={() => void logout()}>
              {t("user.logout")}
            </Button>
          )}
        </Stack>
      </Popover.Dropdown>
    </Popover>
  );
}
