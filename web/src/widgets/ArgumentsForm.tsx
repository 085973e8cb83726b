import { Divider, Stack, Text } from "@mantine/core";
import type { TFunction } from "i18next";
import { useMemo } from "react";
import { useTranslation } from "react-i18next";
import { said } from "../i18n/sentences";
import { Input, placeholderOf } from "./arguments/Input";
import {
  argumentFaults,
  type Arguments,
  type Fault,
  inputKind,
  type Parameter,
  shapeOf,
  shownParameters,
  withArgument,
} from "./arguments/schemas";
import { faultText } from "./faults";

export { argumentFaults, type Arguments } from "./arguments/schemas";

interface Props {
  parameters: readonly Parameter[];
  value: Arguments;
  onChange: (value: Arguments) => void;
  /** Planning parameters are inferred, and hidden unless requested. */
  hidePlanning?: boolean;
  /** Notes on parameters, by key: the inferred value, or why there is none. These are not marked as required. */
  notes?: Readonly<Record<string, string>>;
}

/** The arguments of a module: an input for each parameter by its schema, with help, unit, default and fault. */
export function ArgumentsForm({ parameters, value, onChange, hidePlanning = true, notes = {} }: Props) {
  const { t } = useTranslation("modules");
  const { said, spare } = useMemo(() => shownParameters(parameters, hidePlanning), [parameters, hidePlanning]);
  const faults = useMemo(() => argumentFaults(parameters, value), [parameters, value]);
  const field = (parameter: Parameter) => (
    <Field
      key={parameter.key}
      parameter={parameter}
      note={notes[parameter.key]}
      fault={faults[parameter.key]}
      value={value[parameter.key] ?? undefined}
      onChange={(next) => onChange(withArgument(value, parameter.key, next))}
    />
  );
  if (said.length + spare.length === 0) return <Text size="sm">{t("form.nothing")}</Text>;
  return (
    <Stack gap="xs" role="group" aria-label={t("form.label")}>
      {said.map(field)}
      {spare.length > 0 && said.length > 0 && <Divider label={t("form.spare")} labelPosition="left" />}
      {spare.map(field)}
    </Stack>
  );
}

interface FieldProps {
  parameter: Parameter;
  note: string | undefined;
  fault: Fault | undefined;
  value: unknown;
  onChange: (value: unknown) => void;
}

function Field({ parameter, note, fault, value, onChange }: FieldProps) {
  const { t } = useTranslation("modules");
  const shape = useMemo(() => shapeOf(parameter), [parameter]);
  const { key, unit, help, kind } = parameter;
  const named = inputKind(shape) === "pose" || !unit ? key : `${key} [${unit}]`;
  return (
    <Input
      label={named}
      help={[said(help), note].filter(Boolean).join(" ")}
      error={fault && wordsFor(t, fault)}
      placeholder={placeholderOf(parameter.default)}
      required={kind === "online" && note === undefined}
      shape={shape}
      value={value}
      onChange={onChange}
    />
  );
}

/** In the same words as faults found by the server. */
function wordsFor(t: TFunction<"modules">, { keyword, limit, text }: Fault): string {
  if (keyword === "required" || keyword === "type") return t(`form.faults.${keyword}`);
  return typeof limit === "number" ? faultText({ message: text, kind: keyword, limit }) : text;
}
