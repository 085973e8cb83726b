import { Gone } from "../world/details/Gone";
import { useRemoval } from "../world/details/removal";

/** Says of those elements of a condition that were removed who did it, and offers to bring them back. */
export function GoneThings({ ids }: { ids: readonly string[] }) {
  return ids.map((id) => <GoneThing key={id} id={id} />);
}

function GoneThing({ id }: { id: string }) {
  const { data: removal } = useRemoval(id);
  return removal ? <Gone id={id} /> : null;
}
