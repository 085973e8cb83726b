import { Anchor, Text } from "@mantine/core";
import { useQuery } from "@tanstack/react-query";
import { answer, api } from "../../api/client";
import { keys } from "../../api/keys";
import { useSelection } from "../../selection/selection";
import { useClasses } from "../../world/classes";
import { useView } from "../../world/useView";
import { useWords } from "../../world/useWords";
import { written } from "../../world/values";

/** The names that a text in an answer may be. */
export interface Known {
  elements: ReadonlySet<string>;
  classes: { has: (name: string) => boolean };
}

const PAGE = 1000;
const NONE: ReadonlySet<string> = new Set();

/** Answers contain names and texts alike as strings: whether one is a name must be looked up. */
export function useKnown(): Known {
  const classes = useClasses();
  const { data } = useQuery({ queryKey: keys.world("ids"), queryFn: readIds });
  return { elements: data ?? NONE, classes };
}

async function readIds(): Promise<ReadonlySet<string>> {
  const ids = new Set<string>();
  let cursor: string | undefined;
  do {
    const page = await answer(api.GET("/api/v1/elements", { params: { query: { limit: PAGE, cursor } } }));
    page.items.forEach(({ id }) => ids.add(id));
    cursor = page.next ?? undefined;
  } while (cursor !== undefined);
  return ids;
}

/** A value of an answer; names are links. */
export function Cell({ value, known }: { value: unknown; known: Known }) {
  const words = useWords();
  const [, , show] = useView();
  const text = value === null || value === undefined ? "" : written(value, words);
  const follow = known.classes.has(text)
    ? () => show("ontology", text)
    : known.elements.has(text)
      ? () => select(text, () => show("scene"))
      : null;
  if (typeof value !== "string" || follow === null) {
    return (
      <Text size="sm" style={{ overflowWrap: "anywhere" }}>
        {text}
      </Text>
    );
  }
  return (
    <Anchor component="button" type="button" size="sm" onClick={follow}>
      {text}
    </Anchor>
  );
}

function select(id: string, then: () => void): void {
  useSelection.getState().choose(id);
  then();
}
