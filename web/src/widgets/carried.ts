import { useQuery } from "@tanstack/react-query";
import { classesOf, classTree } from "./names";

const CARRIED = "sk:Manipulatable";

/** Returns a predicate for portable classes: only for those any element of the class will do. */
export function useIsCarried(): (class_: string) => boolean {
  const { data } = useQuery({
    ...classTree(CARRIED),
    select: (root) => new Set(classesOf(root).map(({ name }) => name)),
  });
  return (class_) => data?.has(class_) ?? false;
}
