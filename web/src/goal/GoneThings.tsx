import { Gone } from "../world/details/Gone";
import { useRemoval } from "../world/details/removal";

/** For removed elements of a condition, shows who removed them, and offers to restore them. */
export function GoneThings({ ids }: { ids: readonly string[] }) {
  return ids.map((id) => <GoneThing key={id} id={id} />);
}

function GoneThing({ id }: { id: string }) {
  const { data: removal } = useRemoval(id);
  return removal ? <Gone id={id} /> : null;
}
