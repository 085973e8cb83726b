import { Select } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { classesOf, classTree, localName } from "../widgets/names";

interface Props {
  label: string;
  class_: string;
  value: string;
  onChange: (class_: string) => void;
}

/** Chooses a subclass of a class, such as a kind of part. */
export function ClassPicker({ label, class_, value, onChange }: Props) {
  const { data: tree } = useQuery(classTree(class_));
  const options = tree
    ? classesOf(tree).map(({ name, label: title }) => ({ value: name, label: title || localName(name) }))
    : [];
  return (
    <Select
      aria-label={label}
      data={options}
      value={value || null}
      onChange={(chosen) => onChange(chosen ?? "")}
      searchable
      comboboxProps={{ width: "max-content", position: "bottom-start" }}
    />
  );
}
