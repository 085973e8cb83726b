import { type ComponentProps, useState } from "react";
import { NumberField } from "./NumberField";

interface Props extends Omit<ComponentProps<typeof NumberField>, "value" | "onChange" | "allowDecimal"> {
  value: number;
  min: number;
  max: number;
  onChange: (value: number) => void;
}

/** An input for an integer that is always valid: the value is kept while the field is empty. */
export function CountField({ value, min, max, onChange, ...rest }: Props) {
  const [unfit, setUnfit] = useState<{ written: number | undefined } | null>(null); // empty, or not an integer
  const take = (next: number | undefined) => {
    const fits = next !== undefined && !Number.isNaN(next);
    setUnfit(fits ? null : { written: next });
    if (fits) onChange(Math.min(max, Math.max(min, next)));
  };
  return (
    <NumberField
      {...rest}
      min={min}
      max={max}
      allowDecimal={false}
      value={unfit ? unfit.written : value}
      onChange={take}
      onBlur={() => setUnfit(null)}
    />
  );
}
