"""The ontology's own individuals are elements of every world, and nobody writes to them."""

from __future__ import annotations

from pathlib import Path

import pytest

from skiros_py.errors import FileError, WorldError
from skiros_py.geometry import Pose
from skiros_py.world.ontology import Ontology
from skiros_py.world.world import World

HEADER = """@prefix my: <https://example.org/my#> .
@prefix kitting: <https://w3id.org/skiros-py/kitting#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
my:ReusableThing a owl:Class .
my:Tray a owl:Class ; rdfs:subClassOf kitting:Kit , my:ReusableThing .
my:batch a owl:DatatypeProperty .
my:madeBy a owl:ObjectProperty .
"""


def world_of(root: Path, folder: Path, text: str) -> World:
    file = folder / "my.ttl"
    file.write_text(HEADER + text, encoding="utf-8")
    return World(Ontology.load([root / "ontologies", file]))


def test_the_shipped_kit_is_a_template_with_its_compartments(ontology: Ontology) -> None:
    world = World(ontology)
    pieces = world.objects("kitting:standard_kit", "sk:hasA")

    assert world.abstracts("kitting:Kit") == ("kitting:standard_kit",)
    assert world.instances("kitting:Kit") == ()
    assert pieces == tuple(f"kitting:standard_kit_{letter}" for letter in "abcd")
    assert all(world.objects(piece, "sk:poseFrame") == ("kitting:standard_kit",) for piece in pieces)
    assert world.value(pieces[0], "sk:pose") == Pose.of(-0.073, 0.073, 0.006)
    assert world.element(pieces[1]).label == "compartment B"


def test_abstract_elements_of_an_ontology_cannot_be_changed(ontology: Ontology) -> None:
    world = World(ontology)

    with pytest.raises(WorldError, match="never changed at run time"), world.transaction("me", "why not") as tx:
        tx.set("kitting:standard_kit", "sk:mass", 3.0)


def test_an_individual_with_several_classes_gets_the_most_specific_element_class(root: Path, tmp_path: Path) -> None:
    world = world_of(root, tmp_path, "my:a a owl:NamedIndividual , kitting:Kit , my:Tray , sk:Container .")

    assert world.element("my:a").type == "my:Tray"


def test_statements_that_an_element_cannot_hold_are_only_in_the_graph(root: Path, tmp_path: Path) -> None:
    world = world_of(
        root,
        tmp_path,
        """my:acme a my:ReusableThing .

my:a a my:Tray , my:ReusableThing ; rdfs:label "Schale"@de , "tray"@en ; my:madeBy my:acme , kitting:Kit ;
    my:batch 1 , 2 ; rdfs:seeAlso <https://example.org> ; sk:hasA [ a kitting:Compartment ] .""",
    )

    assert [name for name in world.abstracts("sk:Element") if name.startswith("my:")] == ["my:a"]
    assert world.element("my:a").label == "tray"
    assert dict(world.element("my:a").properties) == {}
    assert world.objects("my:a", "my:madeBy") == ()


def test_values_that_do_not_fit_the_chosen_class_of_an_individual_are_ignored(root: Path, tmp_path: Path) -> None:
    world = world_of(root, tmp_path, "my:a a kitting:Starter , sk:Skill ; sk:mass 1.0 ; sk:maxGap 2.0 .")

    assert dict(world.element("my:a").properties) == {"sk:mass": 1.0}


@pytest.mark.parametrize(
    ("text", "line", "says"),
    [
        ("my:a a my:Tray ;\n sk:mass 'heavy' .", 11, "needs a finite number"),
        ("my:a a my:Tray ;\n sk:maxGap 1.0 .", 11, "belongs to a sk:Gripper"),
        ("my:a a my:Tray ; sk:hasA my:b .\nmy:b a my:Tray ;\n sk:heldBy my:a .", 12, "its object must be a sk:Gripper"),
        ("my:a a my:Tray ; sk:hasA my:b .\nmy:b a my:Tray ; sk:hasA my:a .", 10, "is inside itself"),
        ("my:a a my:Tray ; sk:in my:b , my:c . my:b a my:Tray . my:c a my:Tray .", 10, "one of these, not all"),
        ("my:a a my:Tray ; sk:near my:b .\nmy:b a my:Tray .", 10, "computed by a reasoner"),
    ],
)
def test_an_invalid_entry_is_refused_with_its_line(root: Path, tmp_path: Path, text: str, line: int, says: str) -> None:
    with pytest.raises(FileError) as caught:
        world_of(root, tmp_path, text)

    assert says in caught.value.reason
    assert (caught.value.path.name, caught.value.line) == ("my.ttl", line)
