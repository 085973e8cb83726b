from __future__ import annotations

import warnings
from pathlib import Path

import owlready2
import pytest
import rdflib

ROBOTS = ("three_finger_gripper", "mobile_panda", "mobile_iiwa", "mobile_fanuc", "ur10e_cell")
FILES = ("core.ttl", "kitting.ttl", *(f"../robots/src/skiros_robots/{robot}.ttl" for robot in ROBOTS))


@pytest.mark.parametrize("last", range(1, len(FILES) + 1))
def test_the_ontologies_are_owl_that_other_tools_read(root: Path, tmp_path: Path, last: int) -> None:
    graph = rdflib.Graph()
    for name in FILES[:last]:
        graph.parse(root / "ontologies" / name, format="turtle")
    graph.remove((None, rdflib.OWL.imports, None))  # all are in this graph; nothing is to be fetched
    path = tmp_path / "all.rdf"

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # rdflib warns of every list, as unions are
        graph.serialize(path, format="pretty-xml")
        loaded = owlready2.World().get_ontology(path.as_uri()).load()

    core = loaded.get_namespace("https://w3id.org/skiros-py/core#")
    assert core.Location in core.Floor.ancestors()
    assert core.placement in core.heldBy.is_a
    assert {c.name for c in core.Arm.is_a} == {"Device", "Agent"}


@pytest.mark.parametrize("name", FILES)
def test_every_term_that_an_ontology_uses_is_declared_as_owl(root: Path, name: str) -> None:
    everything = rdflib.Graph()
    for file in FILES:
        everything.parse(root / "ontologies" / file, format="turtle")
    kinds = (
        rdflib.OWL.Class,
        rdflib.OWL.ObjectProperty,
        rdflib.OWL.DatatypeProperty,
        rdflib.OWL.AnnotationProperty,
        rdflib.RDFS.Datatype,
    )
    declared = {s for kind in kinds for s in everything.subjects(rdflib.RDF.type, kind)}

    graph = rdflib.Graph().parse(root / "ontologies" / name, format="turtle")

    assert {p for p in graph.predicates() if not p.startswith("http://www.w3.org/")} <= declared
