"""What was learned has a file of its own, which is checked like a scene."""

from __future__ import annotations

from pathlib import Path

import pytest

from skiros_py.errors import FileError, WorldError
from skiros_py.world.change import Change, Writer
from skiros_py.world.ontology import Ontology
from skiros_py.world.scene.learned import import_learned, learned_turtle, read_learned
from skiros_py.world.undo import undo
from skiros_py.world.world import World

HEADER = """@prefix learned: <https://w3id.org/skiros-py/learned#> .
@prefix scene: <https://w3id.org/skiros-py/scene#> .
@prefix kitting: <https://w3id.org/skiros-py/kitting#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
"""


def test_a_learned_concept_can_have_any_class_and_has_no_place(world: World) -> None:
    with world.transaction("teacher", "shown by hand") as tx:
        kit = tx.add("kitting:Kit", "tall kit", properties={"sk:appliesTo": "kitting:Kit"}, learned=True)
        tx.relate(kit, "sk:hasA", tx.add("kitting:Compartment", "hollow", learned=True))

    assert learned_turtle(world.snapshot()).splitlines() == [
        "@prefix kitting: <https://w3id.org/skiros-py/kitting#> .",
        "@prefix learned: <https://w3id.org/skiros-py/learned#> .",
        "@prefix owl: <http://www.w3.org/2002/07/owl#> .",
        "@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .",
        "@prefix sk: <https://w3id.org/skiros-py/core#> .",
        "",
        "<https://w3id.org/skiros-py/learned> a owl:Ontology ;",
        "    owl:imports <https://w3id.org/skiros-py/core> ;",
        "    owl:imports <https://w3id.org/skiros-py/kitting> ;",
        "    .",
        "",
        "learned:compartment_1 a kitting:Compartment ;",
        '    rdfs:label "hollow" ;',
        "    .",
        "",
        "learned:kit_1 a kitting:Kit ;",
        '    rdfs:label "tall kit" ;',
        "    sk:hasA learned:compartment_1 ;",
        '    sk:appliesTo "kitting:Kit"^^sk:className ;',
        "    .",
    ]


def test_a_learned_concept_for_an_unknown_class_is_refused_with_the_nearest_class(world: World) -> None:
    with (
        pytest.raises(WorldError, match=r"needs the name of a class.*Did you mean 'kitting:Starter'"),
        world.transaction("teacher", "shown") as tx,
    ):
        tx.add("kitting:Kit", properties={"sk:appliesTo": "kitting:Startr"}, learned=True)


@pytest.mark.parametrize(
    ("text", "line", "says"),
    [
        ("learned:a a kitting:Kitt .", 5, "Did you mean 'kitting:Kit'"),
        (
            "learned:a a kitting:Kit ;\n sk:appliesTo 'kitting:Startr'^^sk:className .",
            6,
            "Did you mean 'kitting:Starter'",
        ),
        ("learned:a a kitting:Kit ;\n sk:hasA learned:b .", 6, "unknown individual 'learned:b'"),
        ("learned:a a kitting:Kit ;\n sk:hasA scene:b .", 6, "unknown individual 'b'"),
        ("scene:a a kitting:Kit .", 5, "may speak of learned: individuals only"),
        ("learned:a-b a kitting:Kit .", 5, "is no id"),
        ("learned:a a kitting:Kit ; sk:mass 'heavy' .", 5, "needs a finite number"),
    ],
)
def test_a_wrong_file_is_refused_with_its_line(
    ontology: Ontology, tmp_path: Path, text: str, line: int, says: str
) -> None:
    file = tmp_path / "learned.ttl"
    file.write_text(HEADER + text, encoding="utf-8")

    with pytest.raises(FileError) as caught:
        read_learned(ontology, file)

    assert says in caught.value.reason
    assert caught.value.line == line


# ---------------------------------------------------------------- importing into a world that is


def imported(world: World, folder: Path, text: str, *, replace: bool = False) -> Change | None:
    file = folder / "more.ttl"
    file.write_text(HEADER + RDFS + text, encoding="utf-8")
    with world.transaction("ann", "imports", writer=Writer.PERSON) as tx:
        import_learned(world, tx, file, replace=replace)
    return tx.change


RDFS = "@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .\n"
TALL = "learned:tall a kitting:Kit ; rdfs:label 'tall' ; sk:hasA learned:slot . learned:slot a kitting:Compartment ."


def test_imported_concepts_are_one_change_that_an_undo_reverts(world: World, tmp_path: Path) -> None:
    before = learned_turtle(world.snapshot())

    change = imported(world, tmp_path, TALL)

    assert change is not None
    assert (change.author, change.writer) == ("ann", Writer.PERSON)
    assert world.objects("learned:tall", "sk:hasA") == ("learned:slot",)
    undo(world, "ann")
    assert learned_turtle(world.snapshot()) == before


def test_concepts_that_exist_already_are_left_and_new_ones_added(world: World, tmp_path: Path) -> None:
    imported(world, tmp_path, TALL)

    again = imported(world, tmp_path, TALL)
    more = imported(world, tmp_path, TALL + "learned:low a kitting:Kit .")

    assert again is None
    assert more is not None
    assert [edit.as_json()["element"] for edit in more.edits] == ["learned:low"]


def test_a_different_concept_is_refused_unless_it_is_to_be_replaced(world: World, tmp_path: Path) -> None:
    imported(world, tmp_path, TALL)
    other = "learned:tall a kitting:Kit ; rdfs:label 'taller' ; sk:mass 0.5 ."

    with pytest.raises(WorldError, match="learned:tall: known already, and different"):
        imported(world, tmp_path, other)
    assert world.element("learned:tall").label == "tall"

    imported(world, tmp_path, other, replace=True)
    assert (world.element("learned:tall").label, world.has("learned:slot")) == ("taller", False)


def test_replacing_a_concept_keeps_its_parts_that_are_the_same(world: World, tmp_path: Path) -> None:
    imported(world, tmp_path, TALL)

    imported(world, tmp_path, TALL.replace("'tall'", "'taller'"), replace=True)

    assert world.element("learned:tall").label == "taller"
    assert world.objects("learned:tall", "sk:hasA") == ("learned:slot",)


@pytest.mark.parametrize(
    "text", ["sk:Robot rdfs:label 'mine' .", "learned:a a kitting:Kit . kitting:standard_kit sk:mass 3 ."]
)
def test_a_file_that_touches_terms_or_individuals_of_others_is_refused(world: World, tmp_path: Path, text: str) -> None:
    version = world.version

    with pytest.raises(FileError, match=r"may speak of learned: individuals only; '.*' belongs into an ontology file"):
        imported(world, tmp_path, text)
    assert world.version == version
