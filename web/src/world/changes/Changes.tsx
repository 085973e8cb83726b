import { useInfiniteQuery } from "@tanstack/react-query";
import { answer, api } from "../../api/client";
import { keys } from "../../api/keys";
import { ChangeList } from "./ChangeList";

const PAGE = 30;

/** All changes of the world, latest first. */
export function Changes() {
  const query = useInfiniteQuery({
    queryKey: keys.world("changes"),
    queryFn: ({ pageParam }) =>
      answer(
        api.GET("/api/v1/world/changes", {
          params: { query: { newest_first: true, limit: PAGE, cursor: pageParam } },
        }),
      ),
    initialPageParam: undefined as string | undefined,
    getNextPageParam: (page) => page.next ?? undefined,
  });
  return <ChangeList query={query} />;
}
