import { ActionIcon, Group, Select, Stack, Tooltip } from "@mantine/core";
import { IconTrash } from "@tabler/icons-react";
import { useTranslation } from "react-i18next";
import { intoView } from "../../widgets/intoView";
import { type PropertyInfo, useClass } from "../queries";
import { kindOf, type ValueKind } from "../values";
import { type Draft, without } from "./draft";
import { ValueInput } from "./ValueInput";

interface Props {
  class_: string;
  /** Own values by property; other fields of the draft are unchanged. */
  draft: Draft;
  onChange: (draft: Draft) => void;
  errors: Readonly<Record<string, string>>;
}

const FIRST: Readonly<Record<ValueKind, unknown>> = {
  number: 0,
  integer: 0,
  boolean: true,
  pose: { position: [0, 0, 0], orientation: [0, 0, 0, 1] },
  vector: "",
  json: "[]",
  class: null,
  text: "",
};

/** Edits the own values of an element: change, remove, and add those that its class permits. */
export function PropertyFields({ class_, draft, onChange, errors }: Props) {
  const { t } = useTranslation("world");
  const { data } = useClass(class_);
  const known = data?.properties ?? [];
  const own = known.filter(({ name }) => name in draft);
  return (
    <Stack gap="xs">
      {own.map((info) => (
        <Field
          key={info.name}
          info={info}
          value={draft[info.name]}
          error={errors[info.name]}
          onChange={(value) => onChange({ ...draft, [info.name]: value })}
          onRemove={() => onChange(without(draft, info.name))}
        />
      ))}
      <Select
        label={t("edit.addProperty")}
        placeholder={t("edit.choose")}
        data={known.filter(({ name }) => !(name in draft)).map(({ name, label }) => ({ value: name, label }))}
        searchable
        value={null}
        onChange={(name) => name && onChange({ ...draft, [name]: beginning(known, name) })}
      />
    </Stack>
  );
}

/** The initial value: that of the class, if any. */
function beginning(known: readonly (PropertyInfo & { value?: unknown })[], name: string): unknown {
  const info = known.find((one) => one.name === name);
  return info?.value ?? FIRST[kindOf(info?.datatype ?? "")];
}

interface FieldProps {
  info: PropertyInfo;
  value: unknown;
  error: string | undefined;
  onChange: (value: unknown) => void;
  onRemove: () => void;
}

function Field({ info, value, error, onChange, onRemove }: FieldProps) {
  const { t } = useTranslation("world");
  const label = t("edit.removeValue", { property: info.label });
  return (
    <Group align="start" wrap="nowrap" gap={6}>
      <div ref={error ? intoView : undefined} style={{ flex: 1, minWidth: 0, scrollMarginBottom: 70 }}>
        <ValueInput info={info} value={value} onChange={onChange} error={error} />
      </div>
      <Tooltip label={label}>
        <ActionIcon aria-label={label} onClick={onRemove} mt={20}>
          <IconTrash size={15} />
        </ActionIcon>
      </Tooltip>
    </Group>
  );
}
