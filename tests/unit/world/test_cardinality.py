"""An element has as many things by a relation or property as its class allows, after every transaction."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from skiros_py.errors import WorldError
from skiros_py.world.element import Placement
from skiros_py.world.ontology import Ontology
from skiros_py.world.transaction import Transaction
from skiros_py.world.world import World

HEAD = """@prefix my: <https://example.org/my#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
@prefix xsd: <http://www.w3.org/2001/XMLSchema#> .
my:Cup a owl:Class ; rdfs:subClassOf sk:Object .
my:BigCup a owl:Class ; rdfs:subClassOf my:Cup .
my:Saucer a owl:Class ; rdfs:subClassOf sk:Object .
my:Tray a owl:Class ; rdfs:subClassOf sk:Container .
my:SmallTray a owl:Class ; rdfs:subClassOf my:Tray .
my:goesWith a owl:ObjectProperty ; rdfs:domain my:Cup .
my:fond a owl:ObjectProperty ; rdfs:subPropertyOf my:goesWith .
my:bears a owl:ObjectProperty ; rdfs:subPropertyOf sk:placement ; sk:placeEnd "subject" ;
    rdfs:domain my:Tray ; rdfs:range my:Cup .
my:batch a owl:DatatypeProperty ; rdfs:domain my:Cup ; rdfs:range xsd:string .
"""
CUP = "my:Cup rdfs:subClassOf [ a owl:Restriction ; owl:onProperty {} ] ."
TRAY = "my:Tray rdfs:subClassOf [ a owl:Restriction ; owl:onProperty {} ] ."

Write = Callable[[Transaction], object]
Open = Callable[..., World]


@pytest.fixture
def opened(root: Path, tmp_path: Path) -> Open:
    """Opens a world of an ontology with what is said of cups and trays; all its things stand on the floor."""

    def make(text: str, **things: str) -> World:
        file = tmp_path / "my.ttl"
        file.write_text(HEAD + text, encoding="utf-8")
        world = World(Ontology.load([root / "ontologies" / "core.ttl", file]))
        with world.transaction("test", "things") as tx:
            tx.add("sk:Floor", id="floor")
            for name, class_ in things.items():
                tx.add(class_, id=name, placement=Placement("sk:on", "floor"))
        return world

    return make


def write(world: World, *writes: Write) -> None:
    with world.transaction("test", "try it") as tx:
        for one in writes:
            one(tx)


def refusal(world: World, *writes: Write) -> str:
    before = world.version
    with pytest.raises(WorldError) as caught:
        write(world, *writes)
    assert world.version == before
    return str(caught.value).removeprefix("transaction of test (try it) refused: ")


def states(subject: str, relation: str, object_: str) -> Write:
    return lambda tx: tx.relate(subject, relation, object_)


def takes_back(subject: str, relation: str, object_: str) -> Write:
    return lambda tx: tx.unrelate(subject, relation, object_)


def test_exceeding_a_maximum_cardinality_is_refused_with_the_present_values(opened: Open) -> None:
    text = CUP.format("my:goesWith ; owl:maxCardinality 1")
    world = opened(text, cup="my:Cup", a="my:Saucer", b="my:Saucer")
    write(world, states("cup", "my:goesWith", "a"))

    assert refusal(world, states("cup", "my:goesWith", "b")) == (
        "cup (my:Cup) must have by my:goesWith at most 1, and there are 2 (a, b)"
    )


def test_falling_below_a_minimum_cardinality_is_refused(opened: Open) -> None:
    text = CUP.format("my:goesWith ; owl:minCardinality 2")
    world = opened(text, a="my:Saucer", b="my:Saucer")

    def cup(tx: Transaction) -> None:
        tx.add("my:Cup", id="cup", placement=Placement("sk:on", "floor"))

    assert refusal(world, cup) == "cup (my:Cup) must have by my:goesWith at least 2, and there is none"
    assert refusal(world, cup, states("cup", "my:goesWith", "a")).endswith("at least 2, and there are 1")

    write(world, cup, states("cup", "my:goesWith", "a"), states("cup", "my:goesWith", "b"))
    assert refusal(world, takes_back("cup", "my:goesWith", "b")).endswith("at least 2, and there are 1")


def test_removing_an_element_required_by_a_minimum_cardinality_is_refused(opened: Open) -> None:
    world = opened(CUP.format("my:goesWith ; owl:minCardinality 1"), a="my:Saucer")
    write(
        world,
        lambda tx: tx.add("my:Cup", id="cup", placement=Placement("sk:on", "floor")),
        states("cup", "my:goesWith", "a"),
    )

    assert refusal(world, lambda tx: tx.remove("a")).endswith("at least 1, and there is none")
    write(world, lambda tx: tx.remove("a"), lambda tx: tx.remove("cup"))


def test_cardinalities_are_checked_at_the_end_of_the_transaction(opened: Open) -> None:
    text = CUP.format("my:goesWith ; owl:maxCardinality 1")
    world = opened(text, cup="my:Cup", a="my:Saucer", b="my:Saucer")
    write(world, states("cup", "my:goesWith", "a"))

    write(world, states("cup", "my:goesWith", "b"), takes_back("cup", "my:goesWith", "a"))

    assert world.objects("cup", "my:goesWith") == ("b",)


def test_numbers_hold_for_subclasses_and_count_narrower_relations(opened: Open) -> None:
    text = CUP.format("my:goesWith ; owl:maxCardinality 1")
    world = opened(text, mug="my:BigCup", a="my:Saucer", b="my:Saucer")
    write(world, states("mug", "my:fond", "a"))

    assert "mug (my:BigCup) must have by my:goesWith at most 1" in refusal(world, states("mug", "my:goesWith", "b"))


def test_a_qualified_cardinality_counts_only_elements_of_its_class(opened: Open) -> None:
    text = CUP.format("my:goesWith ; owl:maxQualifiedCardinality 1 ; owl:onClass my:Cup")
    world = opened(text, cup="my:Cup", mug="my:BigCup", a="my:Saucer", b="my:Saucer", other="my:Cup")
    write(world, states("cup", "my:goesWith", "a"), states("cup", "my:goesWith", "b"))
    write(world, states("cup", "my:goesWith", "mug"))

    assert refusal(world, states("cup", "my:goesWith", "other")) == (
        "cup (my:Cup) must have by my:goesWith a my:Cup at most 1, and there are 2 (mug, other)"
    )


def test_a_required_property_can_be_set_on_the_element_or_its_class(opened: Open) -> None:
    text = CUP.format("my:batch ; owl:cardinality 1")

    def new(class_: str, **batch: str) -> Write:
        properties = {f"my:{name}": value for name, value in batch.items()}
        return lambda tx: tx.add(class_, id="cup", properties=properties, placement=Placement("sk:on", "floor"))

    world = opened(text + ' my:BigCup my:batch "b7" .')
    assert refusal(world, new("my:Cup")) == "cup (my:Cup) must have by my:batch at least 1, and there is none"

    write(world, new("my:Cup", batch="b3"))
    assert refusal(world, lambda tx: tx.set("cup", "my:batch", None)).endswith("at least 1, and there is none")
    write(world, lambda tx: tx.add("my:BigCup", placement=Placement("sk:on", "floor")))


def test_setting_a_property_with_maximum_cardinality_zero_is_refused(opened: Open) -> None:
    world = opened(CUP.format("my:batch ; owl:maxCardinality 0"), cup="my:Cup")

    assert refusal(world, lambda tx: tx.set("cup", "my:batch", "b3")) == (
        "cup (my:Cup) must have by my:batch at most 0, and there are 1"
    )


def test_abstract_elements_may_miss_a_minimum_but_not_exceed_a_maximum_cardinality(opened: Open) -> None:
    text = CUP.format("my:goesWith ; owl:cardinality 1")
    world = opened(text)
    write(world, lambda tx: tx.add("my:Cup", learned=True))
    write(world, *[lambda tx: tx.add("my:Saucer", learned=True)] * 2)

    both = [states("learned:cup_1", "my:goesWith", f"learned:saucer_{number}") for number in (1, 2)]
    assert "at most 1, and there are 2 (learned:saucer_1, learned:saucer_2)" in refusal(world, *both)


def test_the_object_of_an_inverse_functional_relation_has_one_subject(opened: Open) -> None:
    world = opened("my:goesWith a owl:InverseFunctionalProperty .", a="my:Cup", b="my:Cup", saucer="my:Saucer")
    write(world, states("a", "my:goesWith", "saucer"))

    assert refusal(world, states("b", "my:goesWith", "saucer")) == (
        "saucer is the my:goesWith of a and b: it can be so of one only"
    )


def test_narrower_relations_of_a_functional_one_are_counted_together(opened: Open) -> None:
    world = opened("my:goesWith a owl:FunctionalProperty .", cup="my:Cup", a="my:Saucer", b="my:Saucer")
    write(world, states("cup", "my:goesWith", "a"))

    assert "must have by my:goesWith at most 1, and there are 2 (a, b)" in refusal(world, states("cup", "my:fond", "b"))


def test_placements_count_for_the_cardinality_of_the_place(opened: Open) -> None:
    text = TRAY.format("my:bears ; owl:maxCardinality 1")
    world = opened(text, tray="my:Tray", other="my:SmallTray", a="my:Cup", b="my:Cup")
    write(world, states("tray", "my:bears", "a"))
    assert world.placement("a") == Placement("my:bears", "tray")

    assert refusal(world, lambda tx: tx.place("b", "my:bears", "tray")) == (
        "tray (my:Tray) must have by my:bears at most 1, and there are 2 (a, b)"
    )
    write(world, lambda tx: tx.place("b", "my:bears", "other"))
    assert "other (my:SmallTray)" in refusal(world, lambda tx: tx.place("a", "my:bears", "other"))


def test_the_last_element_required_by_a_place_cannot_be_moved_away(opened: Open) -> None:
    world = opened(TRAY.format("my:bears ; owl:minCardinality 1"), a="my:Cup", b="my:Cup")
    write(
        world,
        lambda tx: tx.add("my:Tray", id="tray", placement=Placement("sk:on", "floor")),
        states("tray", "my:bears", "a"),
    )

    assert refusal(world, lambda tx: tx.place("a", "sk:on", "floor")) == (
        "tray (my:Tray) must have by my:bears at least 1, and there is none"
    )
    write(world, lambda tx: tx.place("b", "my:bears", "tray"), lambda tx: tx.place("a", "sk:on", "floor"))
