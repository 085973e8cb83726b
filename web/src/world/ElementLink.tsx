import { Anchor } from "@mantine/core";
import { useSelection } from "../selection/selection";

/** Names an element; who clicks it selects it everywhere, who points at it sees where it is. */
export function ElementLink({ id, label }: { id: string; label?: string }) {
  const { choose, hover } = useSelection.getState();
  return (
    <Anchor
      component="button"
      type="button"
      size="sm"
      ta="left"
      style={{ overflowWrap: "anywhere" }}
      onClick={() => choose(id)}
      onMouseEnter={() => hover(id)}
      onMouseLeave={() => hover(null)}
    >
      {label ?? id}
    </Anchor>
  );
}
