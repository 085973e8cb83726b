import { Badge } from "@mantine/core";
import { IconLock } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { useMe } from "../../api/session";
import { useLocks } from "./locks";

/** Shows who else is editing an element. */
export function LockedBy({ element }: { element: string }) {
  const { t } = useTranslation("world");
  const { data: me } = useMe();
  const lock = useLocks().data?.find((held) => held.element === element);
  if (lock === undefined || lock.owner === me?.name) return null;
  return (
    <Badge color="orange" variant="light" tt="none" leftSection={<IconLock size={12} aria-hidden />}>
      {t("locks.by", { owner: lock.owner })}
    </Badge>
  );
}
