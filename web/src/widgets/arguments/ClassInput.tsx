import { Autocomplete } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { answer, api, type Schema } from "../../api/client";
import { keys } from "../../api/keys";
import type { InputProps } from "./Input";
import { byName } from "../names";

/** Chooses any class by name. */
export function ClassInput({ label, help, error, value, onChange, placeholder, required }: InputProps) {
  const { data = [] } = useQuery({
    queryKey: keys.ontology("classes", "names"),
    queryFn: async () => namesIn(await answer(api.GET("/api/v1/ontology/classes"))).sort(byName),
  });
  return (
    <Autocomplete
      size="xs"
      label={label}
      description={help}
      error={error}
      placeholder={placeholder}
      withAsterisk={required}
      data={data}
      limit={50}
      value={typeof value === "string" ? value : ""}
      onChange={(name) => onChange(name || undefined)}
    />
  );
}

function namesIn(node: Schema<"ClassNode">): string[] {
  return [...new Set([node.name, ...node.children.flatMap(namesIn)])];
}
