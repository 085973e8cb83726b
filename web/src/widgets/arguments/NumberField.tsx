import { Text, TextInput, type TextInputProps } from "@mantine/core";
import { type KeyboardEvent, useState } from "react";
import { useTranslation } from "react-i18next";
import { isNoNumber, numberIn, stepped } from "./numerals";

interface Props extends Omit<TextInputProps, "value" | "onChange" | "defaultValue" | "min" | "max" | "step"> {
  value: number | undefined;
  /** Undefined if empty, NaN if it is not a number (yet). */
  onChange: (value: number | undefined) => void;
  allowDecimal?: boolean;
  unit?: string | undefined;
  /** Step size of the arrow keys, and their limits. */
  step?: number;
  min?: number | undefined;
  max?: number | undefined;
}

const ARROWS: Readonly<Record<string, number>> = { ArrowUp: 1, ArrowDown: -1 };

/** An optional number; partial input ("-", "1,") is kept while typing, also after pasting. */
export function NumberField({ value, onChange, allowDecimal = true, unit, step = 1, min, max, ...rest }: Props) {
  const { t } = useTranslation();
  const [draft, setDraft] = useState(() => textOf(value));
  const text = Object.is(numberIn(draft, !allowDecimal), value) ? draft : textOf(value);
  const take = (next: string) => {
    setDraft(next);
    onChange(numberIn(next, !allowDecimal));
  };
  const arrow = (event: KeyboardEvent) => {
    const direction = ARROWS[event.key];
    if (direction === undefined || rest.readOnly) return;
    event.preventDefault();
    take(textOf(stepped(value, direction * step, { min, max })));
  };
  const wrong = isNoNumber(text, !allowDecimal);
  return (
    <TextInput
      inputMode={allowDecimal ? "decimal" : "numeric"}
      autoComplete="off"
      rightSection={unit ? <Text size="xs">{unit}</Text> : undefined}
      rightSectionWidth={unit ? 12 + 8 * unit.length : undefined}
      rightSectionPointerEvents="none"
      {...rest}
      error={wrong ? t(allowDecimal ? "number.wrong" : "number.notWhole", { text }) : rest.error}
      value={text}
      onChange={(event) => take(event.currentTarget.value)}
      onKeyDown={arrow}
    />
  );
}

function textOf(value: number | undefined): string {
  return value === undefined || Number.isNaN(value) ? "" : String(value);
}
