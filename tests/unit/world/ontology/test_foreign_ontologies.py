"""Ontologies that other people's tools wrote, merged on the core."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest

from skiros_py.errors import WorldError
from skiros_py.world.literals import LONGEST_TEXT
from skiros_py.world.ontology import Ontology
from skiros_py.world.queries.answering import ask, select
from skiros_py.world.terms import Cardinality
from skiros_py.world.world import World

ROOT = Path(__file__).parents[4]
DATA = ROOT / "tests" / "data" / "ontologies"
CLASSES = 2000

PROTEGE_HEAD = """<?xml version="1.0"?>


<!DOCTYPE rdf:RDF [
    <!ENTITY owl "http://www.w3.org/2002/07/owl#" >
    <!ENTITY xsd "http://www.w3.org/2001/XMLSchema#" >
    <!ENTITY rdfs "http://www.w3.org/2000/01/rdf-schema#" >
    <!ENTITY rdf "http://www.w3.org/1999/02/22-rdf-syntax-ns#" >
]>


<rdf:RDF xmlns="http://www.semanticweb.org/somebody/ontologies/2024/1/parts-catalogue#"
     xml:base="http://www.semanticweb.org/somebody/ontologies/2024/1/parts-catalogue"
     xmlns:rdfs="http://www.w3.org/2000/01/rdf-schema#"
     xmlns:owl="http://www.w3.org/2002/07/owl#"
     xmlns:xsd="http://www.w3.org/2001/XMLSchema#"
     xmlns:kitting="http://example.org/another/kitting#"
     xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">
    <owl:Ontology rdf:about="http://www.semanticweb.org/somebody/ontologies/2024/1/parts-catalogue">
        <owl:imports rdf:resource="https://w3id.org/skiros-py/core"/>
    </owl:Ontology>

    <!-- http://www.semanticweb.org/somebody/ontologies/2024/1/parts-catalogue#fits -->

    <owl:ObjectProperty rdf:about="#fits">
        <rdf:type rdf:resource="&owl;SymmetricProperty"/>
        <rdfs:domain rdf:resource="#Part0"/>
    </owl:ObjectProperty>

    <owl:DatatypeProperty rdf:about="#weight"><rdfs:range rdf:resource="&xsd;float"/></owl:DatatypeProperty>

    <owl:Class rdf:about="http://example.org/another/kitting#Pallet"/>

    <!--
    ///////////////////////////////////////////////////////////////////////////////////////
    //
    // Classes
    //
    ///////////////////////////////////////////////////////////////////////////////////////
     -->

    <owl:Class rdf:about="#Part0">
        <rdfs:subClassOf rdf:resource="https://w3id.org/skiros-py/core#Manipulatable"/>
    </owl:Class>
"""


def protege_class(number: int) -> str:
    """One class as Protégé writes it, below the class with half its number."""
    return f"""


    <!-- http://www.semanticweb.org/somebody/ontologies/2024/1/parts-catalogue#Part{number} -->

    <owl:Class rdf:about="#Part{number}">
        <rdfs:label xml:lang="en">part {number}</rdfs:label>
        <rdfs:subClassOf rdf:resource="#Part{number // 2}"/>
        <rdfs:subClassOf>
            <owl:Restriction>
                <owl:onProperty rdf:resource="#fits"/>
                <owl:maxCardinality rdf:datatype="&xsd;nonNegativeInteger">{number % 7}</owl:maxCardinality>
            </owl:Restriction>
        </rdfs:subClassOf>
        <rdfs:comment rdf:datatype="&xsd;string">Number {number} of the catalogue.</rdfs:comment>
    </owl:Class>"""


@pytest.fixture(scope="module")
def robotics() -> Ontology:
    return Ontology.load([ROOT / "ontologies", DATA])


@pytest.fixture(scope="module")
def catalogue_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("protege") / "catalogue.owl"
    path.write_text(PROTEGE_HEAD + "".join(map(protege_class, range(1, CLASSES))) + "\n</rdf:RDF>", encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def catalogue(catalogue_file: Path) -> Ontology:
    return Ontology.load([ROOT / "ontologies", catalogue_file])


# ------------------------------------------------------------ in the manner of IEEE 1872


def test_a_bridge_makes_foreign_classes_subclasses_of_core_classes(robotics: Ontology) -> None:
    assert robotics.is_a("robots:AutonomousRobot", "sk:Robot")
    assert robotics.is_a("sk:Robot", "upper:Device")  # an equivalent class is both above and below
    assert not robotics.is_a("sk:Device", "upper:Device")
    assert "robots:MobileRobot" in robotics.subclasses("sk:SpatialThing")
    assert robotics.classes["robots:Robot"].equivalents == ("sk:Robot",)
    assert robotics.classes["robots:Robot"].parents == ("upper:Agent", "upper:Device")


def test_a_class_defined_as_an_intersection_is_a_subclass_of_its_parts(robotics: Ontology) -> None:
    assert robotics.classes["robots:MobileRobot"].parents == ("robots:Robot",)


def test_cardinality_restrictions_are_inherited(robotics: Ontology) -> None:
    exactly_one_base = Cardinality("robots:hasRobotPart", 1, 1, "robots:RobotBase")
    at_least_one_part = Cardinality("robots:hasRobotPart", 1, None, None)

    assert exactly_one_base in robotics.cardinalities("robots:MobileRobot")
    assert at_least_one_part in robotics.cardinalities("robots:MobileRobot")
    assert exactly_one_base not in robotics.cardinalities("robots:Robot")
    assert robotics.cardinalities("tools:Hammer") == (Cardinality("tools:hasHandle", 1, 1, "tools:Handle"),)


def test_characteristics_of_relations_are_known(robotics: Ontology) -> None:
    part, has_part = robotics.relation("upper:part"), robotics.relation("upper:hasPart")

    assert (part.label, part.transitive, part.inverse, has_part.inverse) == (
        "part of",
        True,
        "upper:hasPart",
        "upper:part",
    )
    assert robotics.relation("upper:connected").symmetric
    assert robotics.relation("robots:hasRobotPart").inverse_functional
    assert robotics.relation("tools:hasHandle").functional


def test_unions_and_intersections_can_be_domains_and_ranges(robotics: Ontology) -> None:
    works_in = robotics.relation("robots:worksIn")

    assert works_in.domains == (("robots:Robot", "robots:RobotGroup"),)
    assert works_in.ranges == (("upper:Artifact",), ("upper:Region",))
    assert (works_in.domain, works_in.range) == (None, None)
    assert robotics.missed_end("robots:MobileRobot", works_in.domains) == ()
    assert robotics.missed_end("robots:RobotBase", works_in.domains) == ("robots:Robot", "robots:RobotGroup")
    assert robotics.missed_end("upper:Region", works_in.ranges) == ("upper:Artifact",)


def test_a_write_is_checked_against_union_ranges(robotics: Ontology) -> None:
    world = World(robotics)
    with world.transaction("test", "a handle for a hammer") as tx:
        tx.add("sk:Floor", id="floor")
        for class_, name in (("tools:Hammer", "hammer"), ("tools:Handle", "handle")):
            tx.add(class_, id=name)
            tx.relate(name, "sk:on", "floor")
        tx.relate("hammer", "tools:hasHandle", "handle")

    assert world.related("hammer", "tools:hasHandle", "handle")
    with (
        pytest.raises(WorldError, match="its subject must be a tools:Hammer or tools:Tool, and handle is a tools:Han"),
        world.transaction("test", "the wrong way round") as tx,
    ):
        tx.relate("handle", "tools:hasHandle", "hammer")


def test_a_text_over_the_length_limit_is_refused_with_a_short_message(robotics: Ontology) -> None:
    def write(property_: str) -> None:
        with World(robotics).transaction("test", "too long") as tx:
            tx.add("sk:Floor", id="floor")
            tx.set("floor", property_, "x" * (LONGEST_TEXT + 1))

    for property_ in ("rdfs:label", "rdfs:comment", "robots:autonomy"):
        with pytest.raises(WorldError, match=str(LONGEST_TEXT)) as caught:
            write(property_)
        assert len(str(caught.value)) < 500


def test_individuals_of_an_ontology_exclude_those_of_a_scene(robotics: Ontology) -> None:
    assert {"robots:pioneer", "tools:bestHammer"} <= set(robotics.individuals)
    assert all(":" in name and not name.startswith("scene:") for name in robotics.individuals)


def test_sparql_queries_foreign_ontologies_and_the_core_together(robotics: Ontology) -> None:
    world = World(robotics)

    below = select(world, "SELECT ?c WHERE { ?c rdfs:subClassOf+ upper:Device } ORDER BY ?c")
    freedom = select(world, "SELECT ?n WHERE { robots:pioneer a robots:MobileRobot ; robots:degreesOfFreedom ?n }")

    assert [row["c"] for row in below] == [
        "robots:AutonomousRobot",
        "robots:Robot",
        "robots:RobotBase",
        "robots:RobotPart",
    ]
    assert freedom == [{"n": 3}]
    assert ask(world, "ASK { tools:Hammer rdfs:subClassOf/rdfs:subClassOf sk:Manipulatable }")


def test_an_ontology_is_the_same_in_another_process(robotics: Ontology) -> None:
    again = pickle.loads(pickle.dumps(robotics))

    assert (again.classes, again.relations, again.properties) == (
        robotics.classes,
        robotics.relations,
        robotics.properties,
    )
    assert again.names.prefixes == robotics.names.prefixes
    assert again.sources == robotics.sources
    assert again.ancestors("robots:MobileRobot") == robotics.ancestors("robots:MobileRobot")


# ------------------------------------------------------------ as Protégé writes it


def test_a_large_protege_file_can_be_queried_by_core_classes(catalogue: Ontology) -> None:
    last = f"parts_catalogue:Part{CLASSES - 1}"

    assert len(catalogue.subclasses("parts_catalogue:Part0")) == CLASSES
    assert catalogue.is_a(last, "sk:Manipulatable")
    assert catalogue.classes[last].label == f"part {CLASSES - 1}"
    assert catalogue.relation("parts_catalogue:fits").symmetric
    rows = select(World(catalogue), "SELECT (COUNT(?c) AS ?n) WHERE { ?c rdfs:subClassOf* parts_catalogue:Part1 }")
    assert rows == [{"n": CLASSES - 1}]


def test_a_hand_written_prefix_takes_precedence_over_a_generated_prefix(catalogue: Ontology) -> None:
    assert catalogue.names.prefixes["kitting"] == "https://w3id.org/skiros-py/kitting#"
    assert "kitting2:Pallet" in catalogue.classes
    assert "kitting:Pallet" in catalogue.classes
