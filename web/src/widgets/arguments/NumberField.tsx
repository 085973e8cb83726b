import { NumberInput, type NumberInputProps } from "@mantine/core";
import { useState } from "react";

interface Props extends Omit<NumberInputProps, "value" | "onChange" | "defaultValue"> {
  value: number | undefined;
  /** Undefined where there is no number (yet). */
  onChange: (value: number | undefined) => void;
}

/** A number, or nothing; what is half written ("-", "1.") stays while it is being written. */
export function NumberField({ value, onChange, ...rest }: Props) {
  const [draft, setDraft] = useState<string | number>(value ?? "");
  const shown = numberOf(draft) === value ? draft : (value ?? "");
  const take = (written: string | number) => {
    setDraft(written);
    onChange(numberOf(written));
  };
  return (
    <NumberInput {...rest} value={shown} onChange={take} allowedDecimalSeparators={[".", ","]} clampBehavior="none" />
  );
}

function numberOf(written: string | number): number | undefined {
  const number = written === "" ? Number.NaN : Number(written);
  return Number.isFinite(number) ? number : undefined;
}
