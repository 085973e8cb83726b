/** Example queries; the names are keys of their texts. */
export const EXAMPLES = {
  where:
    "SELECT ?thing ?relation ?place {\n  ?thing ?relation ?place .\n  ?relation rdfs:subPropertyOf sk:placement .\n}\nORDER BY ?place",
  parts:
    "SELECT ?part ?class ?place {\n  ?part a ?class ; sk:in ?place .\n  ?class rdfs:subClassOf* sk:Manipulatable .\n}",
  poses: "SELECT ?thing ?pose {\n  ?thing sk:pose ?pose .\n}",
  count:
    "SELECT ?class (COUNT(?thing) AS ?how_many) {\n  ?thing a ?class .\n}\nGROUP BY ?class\nORDER BY DESC(?how_many)",
  full: "ASK {\n  ?part sk:in scene:kit_1_a .\n}",
  copy: "CONSTRUCT { ?thing sk:in ?place }\nWHERE { ?thing sk:in ?place }",
} as const;

export type ExampleName = keyof typeof EXAMPLES;

/** The prefixes that the server declares for each query. */
export const PREFIXES = ["sk:", "kitting:", "scene:", "learned:", "rdf:", "rdfs:", "owl:", "xsd:"];
