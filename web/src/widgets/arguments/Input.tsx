import { Fieldset, Group, JsonInput, Select, Stack, TagsInput, Text, TextInput } from "@mantine/core";
import { type ReactNode, useState } from "react";
import { useTranslation } from "react-i18next";
import { ElementPicker } from "../ElementPicker";
import { ClassInput } from "./ClassInput";
import { NumberField } from "./NumberField";
import { type Arguments, count, inputKind, type InputKind, type Shape, withArgument, within } from "./schemas";

export interface InputProps {
  label: string;
  help?: string | undefined;
  error?: string | undefined;
  /** The default. */
  placeholder?: string;
  required?: boolean;
  shape: Shape;
  value: unknown;
  /** Undefined omits the value. */
  onChange: (value: unknown) => void;
}

const INPUTS: Record<InputKind, (props: InputProps) => ReactNode> = {
  element: ElementInput,
  class: ClassInput,
  pose: (props) => <Numbers {...props} names={["x [m]", "y [m]", "z [m]", "roll [rad]", "pitch [rad]", "yaw [rad]"]} />,
  boolean: YesOrNo,
  choice: Choice,
  number: OneNumber,
  integer: OneNumber,
  text: OneText,
  numbers: ManyNumbers,
  vector: (props) => <Numbers {...props} names={namesOf(count(props.shape.schema))} />,
  texts: ManyTexts,
  object: Parts,
  json: Json,
};

/** The input for a value of that shape. */
export function Input(props: InputProps) {
  const Fitting = INPUTS[inputKind(props.shape)];
  return <Fitting {...props} />;
}

function ElementInput({ label, help, error, required, shape, value, onChange }: InputProps) {
  return (
    <ElementPicker
      label={label}
      description={help}
      class_={String(shape.schema.class)}
      value={typeof value === "string" ? value : null}
      onChange={(id) => onChange(id ?? undefined)}
      required={required}
      error={error}
    />
  );
}

function OneNumber({ shape, value, onChange, help, ...rest }: InputProps) {
  const { minimum, maximum, type } = shape.schema;
  return (
    <NumberField
      {...rest}
      description={help}
      withAsterisk={rest.required}
      required={false}
      min={minimum}
      max={maximum}
      allowDecimal={type !== "integer"}
      value={typeof value === "number" ? value : undefined}
      onChange={onChange}
    />
  );
}

function OneText({ label, help, error, placeholder, required, value, onChange }: InputProps) {
  return (
    <TextInput
      label={label}
      description={help}
      error={error}
      placeholder={placeholder}
      withAsterisk={required}
      value={typeof value === "string" ? value : ""}
      onChange={(event) => onChange(event.currentTarget.value || undefined)}
    />
  );
}

/** Yes, no, or undefined, which a switch could not express. */
function YesOrNo({ label, help, error, placeholder, required, value, onChange }: InputProps) {
  const { t } = useTranslation("modules");
  return (
    <Select
      label={label}
      description={help}
      error={error}
      placeholder={placeholder}
      withAsterisk={required}
      clearable
      data={[
        { value: "true", label: t("form.yes") },
        { value: "false", label: t("form.no") },
      ]}
      value={typeof value === "boolean" ? String(value) : null}
      onChange={(said) => onChange(said === null ? undefined : said === "true")}
    />
  );
}

function Choice({ label, help, error, placeholder, required, shape, value, onChange }: InputProps) {
  const choices: unknown[] = shape.schema.enum ?? [shape.schema.const];
  const at = choices.indexOf(value);
  return (
    <Select
      label={label}
      description={help}
      error={error}
      placeholder={placeholder}
      withAsterisk={required}
      clearable
      searchable
      data={choices.map((choice, index) => ({ value: String(index), label: String(choice) }))}
      value={at < 0 ? null : String(at)}
      onChange={(index) => onChange(index === null ? undefined : choices[Number(index)])}
    />
  );
}

function ManyTexts({ label, help, error, required, value, onChange }: InputProps) {
  const { t } = useTranslation("modules");
  return (
    <TagsInput
      size="xs"
      label={label}
      description={help}
      error={error}
      withAsterisk={required}
      placeholder={t("form.more")}
      acceptValueOnBlur
      value={Array.isArray(value) ? value.map(String) : []}
      onChange={(texts) => onChange(texts.length > 0 ? texts : undefined)}
    />
  );
}

/** A list of numbers in one text field. */
function ManyNumbers({ label, help, error, required, value, onChange }: InputProps) {
  const { t } = useTranslation("modules");
  const [draft, setDraft] = useState("");
  const numbers = draft.split(/[\s;]+/).filter(Boolean);
  const shown = JSON.stringify(numbers.map(numeral)) === JSON.stringify(value) ? draft : texts(value).join(" ");
  const take = (written: string) => {
    setDraft(written);
    const said = written.split(/[\s;]+/).filter(Boolean);
    onChange(said.length > 0 ? said.map(numeral) : undefined);
  };
  return (
    <TextInput
      label={label}
      description={help}
      error={error}
      withAsterisk={required}
      placeholder={t("form.numbers")}
      value={shown}
      onChange={(event) => take(event.currentTarget.value)}
    />
  );
}

/** A number if it is one, otherwise the text, which the check then rejects. */
function numeral(word: string): number | string {
  const number = Number(word.replace(",", "."));
  return Number.isFinite(number) ? number : word;
}

function texts(value: unknown): string[] {
  return Array.isArray(value) ? value.map(String) : [];
}

function namesOf(many: number): string[] {
  return many === 3 ? ["x", "y", "z"] : Array.from({ length: many }, (_, index) => String(index + 1));
}

/** A fixed number of named numbers; omitted while all are empty. */
function Numbers({ label, help, error, shape, value, onChange, names }: InputProps & { names: readonly string[] }) {
  const numbers: unknown[] = Array.isArray(value) ? value : [];
  const defaults: unknown[] = Array.isArray(shape.schema.default) ? shape.schema.default : [];
  const take = (index: number, number: number | undefined) => {
    const next = names.map((_, at) => (at === index ? number : numbers[at]) ?? null);
    onChange(next.every((one) => one === null) ? undefined : next);
  };
  return (
    <Fieldset legend={label} p="xs">
      <Group gap="xs" wrap={names.length > 3 ? "wrap" : "nowrap"} align="end">
        {names.map((name, index) => (
          <NumberField
            key={name}
            label={name}
            aria-label={`${label} ${name}`}
            flex="1 1 4rem"
            placeholder={defaults[index] === undefined ? undefined : String(defaults[index])}
            error={Boolean(error)}
            value={typeof numbers[index] === "number" ? numbers[index] : undefined}
            onChange={(number) => take(index, number)}
          />
        ))}
      </Group>
      <Below help={help} error={error} />
    </Fieldset>
  );
}

function Below({ help, error }: Pick<InputProps, "help" | "error">) {
  return (
    <>
      <Text size="xs" c="dimmed" component="div" mt={4}>
        {help}
      </Text>
      {error && (
        <Text size="xs" c="red" role="alert">
          {error}
        </Text>
      )}
    </>
  );
}

/** A value with fields. */
function Parts({ label, help, error, shape, value, onChange }: InputProps) {
  const parts: Arguments = typeof value === "object" && value !== null ? (value as Arguments) : {};
  const take = (key: string, part: unknown) => {
    const next = withArgument(parts, key, part);
    onChange(Object.keys(next).length > 0 ? next : undefined);
  };
  return (
    <Fieldset legend={label} p="xs">
      <Stack gap="xs">
        {Object.entries(shape.schema.properties ?? {}).map(([key, part]) => {
          if (typeof part === "boolean") return null;
          const inner = within(shape, part, "");
          return (
            <Input
              key={key}
              label={key}
              help={inner.schema.description}
              placeholder={placeholderOf(inner.schema.default)}
              required={shape.schema.required?.includes(key) ?? false}
              shape={inner}
              value={parts[key]}
              onChange={(said) => take(key, said)}
            />
          );
        })}
      </Stack>
      <Below help={help} error={error} />
    </Fieldset>
  );
}

/** Returns the placeholder of a field, which shows its default. */
export function placeholderOf(standard: unknown): string {
  if (standard === undefined || standard === null) return "";
  return typeof standard === "object" ? JSON.stringify(standard) : String(standard);
}

function Json({ label, help, error, required, value, onChange }: InputProps) {
  const { t } = useTranslation("modules");
  const [draft, setDraft] = useState(value === undefined ? "" : JSON.stringify(value, null, 1));
  const take = (written: string) => {
    setDraft(written);
    if (written.trim() === "") onChange(undefined);
    else if (isJson(written)) onChange(JSON.parse(written));
  };
  return (
    <JsonInput
      size="xs"
      label={label}
      description={help}
      error={error}
      withAsterisk={required}
      validationError={t("form.noJson")}
      autosize
      minRows={2}
      value={draft}
      onChange={take}
    />
  );
}

function isJson(text: string): boolean {
  try {
    JSON.parse(text);
    return true;
  } catch {
    return false;
  }
}
