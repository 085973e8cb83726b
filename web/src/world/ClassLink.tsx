import { Anchor } from "@mantine/core";
import { useView } from "./useView";

/** Link from a class to its description in the ontology. */
export function ClassLink({ name }: { name: string }) {
  const [, , open] = useView();
  return (
    <Anchor component="button" type="button" size="sm" ta="left" onClick={() => open("ontology", name)}>
      {name}
    </Anchor>
  );
}
