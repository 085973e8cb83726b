import { Button, type ButtonProps, Tooltip } from "@mantine/core";
import type { ComponentPropsWithoutRef } from "react";
import { useTranslation } from "react-i18next";
import { type Operation, useMay } from "../api/session";

interface Props extends ButtonProps, Omit<ComponentPropsWithoutRef<"button">, keyof ButtonProps> {
  /** What it does; those who may not do that see it disabled, and why. */
  operation: Operation;
}

export function MayButton({ operation, disabled, ...rest }: Props) {
  const { t } = useTranslation();
  const may = useMay(operation);
  return (
    <Tooltip label={t("mayNot")} disabled={may}>
      {/* data-disabled keeps it reachable, so that its reason can be read by keyboard, too */}
      <Button
        {...rest}
        disabled={may && disabled}
        {...(!may && { "data-disabled": true, "aria-disabled": true, onClick: ignore })}
      />
    </Tooltip>
  );
}

function ignore(event: { preventDefault: () => void }) {
  event.preventDefault();
}
