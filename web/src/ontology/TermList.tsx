import { Text } from "@mantine/core";
import { useMemo } from "react";
import { type TreeSource, VirtualTree } from "../world/tree/VirtualTree";
import { useView } from "../world/useView";
import { mentions } from "./search";

interface Term {
  name: string;
  label: string;
  comment: string;
}

interface Props {
  label: string;
  terms: readonly Term[];
  search: string;
}

/** Relations or properties, by name. */
export function TermList({ label, terms, search }: Props) {
  const [, chosen, show] = useView();
  const found = useMemo(
    () => new Map(terms.filter((term) => mentions(term, search)).map((term) => [term.name, term])),
    [terms, search],
  );
  const source = useMemo(() => flat(found), [found]);
  return (
    <VirtualTree
      label={label}
      source={source}
      open={NONE}
      onOpen={ignore}
      selected={chosen || null}
      onChoose={(name) => show("ontology", name)}
      row={(name) => (
        <>
          <Text span size="sm" truncate>
            {found.get(name)?.label}
          </Text>
          <Text span size="xs" c="dimmed" truncate>
            {name}
          </Text>
        </>
      )}
    />
  );
}

const NONE: string[] = [];
const ignore = () => undefined;

function flat(terms: ReadonlyMap<string, Term>): TreeSource {
  const names = [...terms.keys()];
  return {
    children: (name) => (name === "" ? names : []),
    name: (name) => terms.get(name)?.label ?? name,
    folder: () => false,
  };
}
