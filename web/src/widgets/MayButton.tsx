import { Button, type ButtonProps, Loader, Tooltip } from "@mantine/core";
import type { ComponentPropsWithoutRef } from "react";
import { useTranslation } from "react-i18next";
import { type Operation, useMay } from "../api/session";

interface Props extends Omit<ButtonProps, "loading">, Omit<ComponentPropsWithoutRef<"button">, keyof ButtonProps> {
  /** The operation of the button; it is disabled, with the reason, for users without permission. */
  operation: Operation;
  /** Whether the operation runs: the button is disabled meanwhile. */
  loading?: boolean;
}

export function MayButton({ operation, disabled, loading = false, leftSection, ...rest }: Props) {
  const { t } = useTranslation();
  const may = useMay(operation);
  return (
    <Tooltip label={t("mayNot")} disabled={may}>
      {/* Only marked as disabled: its reason stays readable by keyboard, and it keeps the focus while it works. */}
      <Button
        {...rest}
        leftSection={loading ? <Loader size={16} color="currentColor" aria-hidden /> : leftSection}
        disabled={may && !loading && disabled}
        aria-busy={loading || undefined}
        {...((!may || loading) && { "data-disabled": true, "aria-disabled": true, onClick: ignore })}
      />
    </Tooltip>
  );
}

function ignore(event: { preventDefault: () => void }) {
  event.preventDefault();
}
