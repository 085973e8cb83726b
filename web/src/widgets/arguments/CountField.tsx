import { type ComponentProps, useState } from "react";
import { NumberField } from "./NumberField";

interface Props extends Omit<ComponentProps<typeof NumberField>, "value" | "onChange" | "allowDecimal"> {
  value: number;
  min: number;
  max: number;
  onChange: (value: number) => void;
}

/** A whole number that always is one: while its field is empty it stays what it was, so that another can be typed. */
export function CountField({ value, min, max, onChange, ...rest }: Props) {
  const [empty, setEmpty] = useState(false);
  const take = (next: number | undefined) => {
    const number = next === undefined || Number.isNaN(next) ? undefined : next;
    setEmpty(number === undefined);
    if (number !== undefined) onChange(Math.min(max, Math.max(min, number)));
  };
  return (
    <NumberField
      {...rest}
      min={min}
      max={max}
      allowDecimal={false}
      value={empty ? undefined : value}
      onChange={take}
      onBlur={() => setEmpty(false)}
    />
  );
}
