import { useMemo } from "react";
import { useClasses } from "../classes";
import { placementsFor } from "../edit/placements";
import { type Details, useAbstracts, useRelations } from "../queries";

interface Option {
  value: string;
  label: string;
}

export interface Options {
  classes: Option[];
  /** Abstract individuals, which are copied with their parts. */
  copies: Option[];
  /** The class of the chosen option. */
  classOf: (value: string | null) => string | null;
}

/** Candidates for adding at a place: classes that the ontology permits, and abstract individuals of such classes. */
export function useOptions(parent: Details | null): Options {
  const classes = useClasses();
  const { data: relations } = useRelations();
  const { data: abstracts } = useAbstracts();
  return useMemo(() => {
    const fits = (name: string) =>
      parent === null || placementsFor(classes, relations ?? [], name, parent.class).length > 0;
    const fitting = [...classes.values()].filter(({ name }) => fits(name));
    const copies = (abstracts ?? []).filter((one) => fits(one.class));
    const kinds = new Map(copies.map((one) => [one.id, one.class]));
    return {
      classes: fitting.map(({ name, label }) => ({ value: name, label: `${label} (${name})` })),
      copies: copies.map(({ id, label }) => ({ value: id, label: `${label} (${id})` })),
      classOf: (value) => (value === null ? null : (kinds.get(value) ?? value)),
    };
  }, [classes, relations, abstracts, parent]);
}
