import { Select, Textarea, TextInput } from "@mantine/core";
import { type ReactNode, useState } from "react";
import { useTranslation } from "react-i18next";
import { NumberField } from "../../widgets/arguments/NumberField";
import { useClasses } from "../classes";
import type { PropertyInfo } from "../queries";
import { isPose, kindOf, type PoseValue, vectorOf } from "../values";
import { PoseInput } from "./PoseInput";

export interface ValueInputProps {
  info: PropertyInfo;
  value: unknown;
  onChange: (value: unknown) => void;
  error?: ReactNode;
}

/** Edits a value of a property by its data type, and shows the server's faults. */
export function ValueInput(props: ValueInputProps) {
  switch (kindOf(props.info.datatype)) {
    case "number":
    case "integer":
      return <NumberValue {...props} />;
    case "boolean":
      return <YesNo {...props} />;
    case "pose":
      return <PoseValueInput {...props} />;
    case "vector":
      return <VectorInput {...props} />;
    case "class":
      return <ClassInput {...props} />;
    default:
      return <TextValue {...props} />;
  }
}

function useCommon({ info, error }: ValueInputProps) {
  const description = info.comment || info.says;
  // The form shows angles in degrees, independent of the server's unit.
  return { label: info.label, description: description.replace("[m, rad]", "[m, °]"), error };
}

function NumberValue(props: ValueInputProps) {
  const { info, value, onChange } = props;
  return (
    <NumberField
      {...useCommon(props)}
      value={typeof value === "number" ? value : undefined}
      onChange={(number) => onChange(number ?? "")} // NaN prevents saving
      allowDecimal={kindOf(info.datatype) === "number"}
      unit={info.unit || undefined}
    />
  );
}

function YesNo(props: ValueInputProps) {
  const { t } = useTranslation("world");
  const data = [
    { value: "true", label: t("value.yes") },
    { value: "false", label: t("value.no") },
  ];
  return (
    <Select
      {...useCommon(props)}
      data={data}
      allowDeselect={false}
      value={String(props.value)}
      onChange={(value) => props.onChange(value === "true")}
    />
  );
}

const NOWHERE: PoseValue = { position: [0, 0, 0], orientation: [0, 0, 0, 1] };

function PoseValueInput(props: ValueInputProps) {
  const { info, value, onChange } = props;
  return (
    <PoseInput
      {...useCommon(props)}
      value={isPose(value) ? value : NOWHERE}
      onChange={onChange}
      framed={info.name === "sk:pose"}
    />
  );
}

function VectorInput(props: ValueInputProps) {
  const { t } = useTranslation("world");
  const { info, value, onChange } = props;
  const [text, setText] = useState(() => (Array.isArray(value) ? value.join(" ") : String(value ?? "")));
  const take = (next: string) => {
    setText(next);
    onChange(vectorOf(next));
  };
  return (
    <TextInput
      {...useCommon(props)}
      placeholder={t("value.vector")}
      value={text}
      onChange={(event) => take(event.currentTarget.value)}
      rightSection={info.unit || undefined}
      rightSectionWidth={info.unit ? 40 : undefined}
    />
  );
}

function ClassInput(props: ValueInputProps) {
  const classes = useClasses();
  const data = [...classes.values()].map(({ name, label }) => ({ value: name, label: `${label} (${name})` }));
  return (
    <Select
      {...useCommon(props)}
      data={data}
      searchable
      value={(props.value as string | undefined) ?? null}
      onChange={props.onChange}
    />
  );
}

function TextValue(props: ValueInputProps) {
  const { info, value, onChange } = props;
  const json = kindOf(info.datatype) === "json";
  return (
    <Textarea
      {...useCommon(props)}
      autosize
      maxRows={12}
      ff={json ? "monospace" : undefined}
      value={typeof value === "string" ? value : JSON.stringify(value ?? "")}
      onChange={(event) => onChange(event.currentTarget.value)}
    />
  );
}
