/** The places that an element consists of: the compartments of a kit. */

import { useQuery } from "@tanstack/react-query";
import { answer, api } from "../api/client";
import { keys } from "../api/keys";
import { nameOf } from "../widgets/names";

export interface Place {
  id: string;
  name: string;
}

const MOST = 200;

/** The parts of an element that have a class; the element itself if there are none. */
export function usePlaces(element: string | null, class_: string) {
  return useQuery({
    queryKey: keys.world("places", element, class_),
    queryFn: () => placesOf(element ?? "", class_),
    enabled: element !== null,
  });
}

async function placesOf(id: string, class_: string): Promise<Place[]> {
  const [details, wanted] = await Promise.all([read(id), subclasses(class_)]);
  const pieces = details.relations.filter(({ family, subject }) => family === "structure" && subject === id);
  const each = await Promise.all(pieces.slice(0, MOST).map(({ object }) => read(object)));
  const places = each.filter((piece) => wanted.has(piece.class));
  return (places.length > 0 ? places : [details]).map(({ id: place, label }) => ({
    id: place,
    name: nameOf(place, label),
  }));
}

function read(id: string) {
  return answer(api.GET("/api/v1/elements/{element}", { params: { path: { element: id } } }));
}

async function subclasses(class_: string): Promise<Set<string>> {
  const path = { name: class_ };
  const { subclasses: all } = await answer(api.GET("/api/v1/ontology/classes/{name}", { params: { path } }));
  return new Set(all);
}
