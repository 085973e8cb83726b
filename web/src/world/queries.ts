/** The queries of the World tab. */

import { useQuery } from "@tanstack/react-query";
import { answer, answerWithTag, api, type Schema } from "../api/client";
import { keys } from "../api/keys";

/** An element with its ETag, which writes based on it must send. */
export type Tagged = Awaited<ReturnType<typeof readElement>>;
export type Details = Tagged["data"];
export type Placement = Schema<"Placement">;
export type RelationInfo = Schema<"RelationInfo">;
export type PropertyInfo = Schema<"PropertyInfo">;

const ALL = 1000;

export function readElement(id: string) {
  return answerWithTag(api.GET("/api/v1/elements/{element}", { params: { path: { element: id } } }));
}

export function useElement(id: string | null) {
  return useQuery({
    queryKey: keys.world("element", id),
    queryFn: () => readElement(id ?? ""),
    enabled: id !== null,
  });
}

export function useWorldInfo() {
  return useQuery({ queryKey: keys.world("info"), queryFn: () => answer(api.GET("/api/v1/world")) });
}

export function useClass(name: string | null) {
  return useQuery({
    queryKey: keys.ontology("class", name),
    queryFn: () => answer(api.GET("/api/v1/ontology/classes/{name}", { params: { path: { name: name ?? "" } } })),
    enabled: name !== null,
  });
}

export function useRelations() {
  return useQuery({
    queryKey: keys.ontology("relations"),
    queryFn: async () =>
      (await answer(api.GET("/api/v1/ontology/relations", { params: { query: { limit: ALL } } }))).items,
  });
}

export function useProperties() {
  return useQuery({
    queryKey: keys.ontology("properties"),
    queryFn: async () =>
      (await answer(api.GET("/api/v1/ontology/properties", { params: { query: { limit: ALL } } }))).items,
  });
}

export function useAbstracts() {
  return useQuery({
    queryKey: keys.world("abstracts"),
    queryFn: async () =>
      (await answer(api.GET("/api/v1/elements", { params: { query: { abstract: true, limit: ALL } } }))).items,
  });
}
