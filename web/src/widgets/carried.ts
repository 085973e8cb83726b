import { useQuery } from "@tanstack/react-query";
import { classesOf, classTree } from "./names";

const CARRIED = "sk:Manipulatable";

/** Returns a test whether things of a class can be carried: only of those does it not matter which one it is. */
export function useIsCarried(): (class_: string) => boolean {
  const { data } = useQuery({
    ...classTree(CARRIED),
    select: (root) => new Set(classesOf(root).map(({ name }) => name)),
  });
  return (class_) => data?.has(class_) ?? false;
}
