import { useInfiniteQuery } from "@tanstack/react-query";
import { answer, api } from "../../api/client";
import { keys } from "../../api/keys";
import { ChangeList } from "../changes/ChangeList";

const PAGE = 20;

/** The changes of an element, latest first. */
export function History({ element }: { element: string }) {
  const query = useInfiniteQuery({
    queryKey: keys.world("history", element),
    queryFn: ({ pageParam }) =>
      answer(
        api.GET("/api/v1/elements/{element}/history", {
          params: { path: { element }, query: { limit: PAGE, cursor: pageParam } },
        }),
      ),
    initialPageParam: undefined as string | undefined,
    getNextPageParam: (page) => page.next ?? undefined,
  });
  return <ChangeList query={query} about={element} />;
}
