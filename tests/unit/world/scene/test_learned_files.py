"""What was learned has a file of its own, which is checked like a scene."""

from __future__ import annotations

from pathlib import Path

import pytest

from skiros_py.errors import FileError, WorldError
from skiros_py.world.ontology import Ontology
from skiros_py.world.scene.learned import learned_turtle, read_learned
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
