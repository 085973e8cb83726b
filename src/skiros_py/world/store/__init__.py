"""The same content as RDF triples, for SPARQL."""
