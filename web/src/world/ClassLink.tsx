import { Anchor } from "@mantine/core";
import { useView } from "./useView";

/** Names a class; leads to what the ontology says of it. */
export function ClassLink({ name }: { name: string }) {
  const [, , open] = useView();
  return (
    <Anchor component="button" type="button" size="sm" ta="left" onClick={() => open("ontology", name)}>
      {name}
    </Anchor>
  );
}
