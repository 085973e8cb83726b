import { useQuery } from "@tanstack/react-query";
import { answer, answerWithTag, api } from "../../api/client";
import { keys } from "../../api/keys";

const ALL = 1000;
const LINES = 200;

/** The current scene, with the ETag that loading another one must send. */
export function usePresent() {
  return useQuery({ queryKey: keys.scenes("present"), queryFn: () => answerWithTag(api.GET("/api/v1/scene")) });
}

export function useScenes() {
  return useQuery({
    queryKey: keys.scenes("list"),
    queryFn: async () => (await answer(api.GET("/api/v1/scenes", { params: { query: { limit: ALL } } }))).items,
  });
}

/** The differences that make the current scene of another one. */
export function useDifference(name: string, enabled: boolean) {
  return useQuery({
    queryKey: keys.scenes("difference", name),
    queryFn: () => answer(api.GET("/api/v1/scene/diff", { params: { query: { with: name, limit: LINES } } })),
    enabled: enabled && name !== "",
  });
}
