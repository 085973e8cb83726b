from __future__ import annotations

from pathlib import Path

import pytest

from skiros_py.errors import FileError, UnknownName, UsageError
from skiros_py.geometry import Pose
from skiros_py.world import vocabulary
from skiros_py.world.ontology import Ontology
from skiros_py.world.terms import Family

HEADER = """@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
@prefix sk: <https://w3id.org/skiros-py/core#> .
@prefix mine: <https://example.org/mine#> .
"""


def load_with(root: Path, folder: Path, text: str) -> Ontology:
    path = folder / "mine.ttl"
    path.write_text(HEADER + text)
    return Ontology.load([root / "ontologies", path])


def test_ancestors_follow_the_primary_parents_line_first(ontology: Ontology) -> None:
    assert ontology.ancestors("sk:Arm") == ("sk:Arm", "sk:Device", "sk:SpatialThing", "sk:Element", "sk:Agent")
    assert ontology.classes["sk:Arm"].primary_parent == "sk:Device"


def test_without_an_annotation_the_alphabetically_first_parent_is_primary(root: Path, tmp_path: Path) -> None:
    ontology = load_with(root, tmp_path, "mine:Cart a owl:Class ; rdfs:subClassOf sk:Object , sk:Container .")

    assert ontology.classes["mine:Cart"].parents == ("sk:Container", "sk:Object")


def test_subclasses_and_sub_relations_include_the_term_itself_first(ontology: Ontology) -> None:
    assert ontology.subclasses("sk:Root") == ("sk:Root", "sk:Floor", "sk:UnknownLocation")
    assert ontology.sub_relations("sk:placement") == (
        "sk:placement",
        "sk:at",
        "sk:heldBy",
        "sk:in",
        "sk:mayBeIn",
        "sk:on",
    )


def test_the_family_of_a_relation_follows_from_its_super_relation(ontology: Ontology) -> None:
    relations = ("sk:heldBy", "sk:hasA", "sk:fitsIn", "sk:hasSkill")

    families = [ontology.family(relation) for relation in relations]

    assert families == [Family.PLACEMENT, Family.STRUCTURE, Family.COMPUTED, Family.PLAIN]


def test_a_class_gives_values_that_subclasses_inherit_or_override(
    ontology: Ontology, root: Path, tmp_path: Path
) -> None:
    mine = load_with(
        root,
        tmp_path,
        "mine:Bin a owl:Class ; rdfs:subClassOf <https://w3id.org/skiros-py/kitting#Pallet> ; sk:mass 3.",
    )

    assert ontology.class_value("kitting:Pallet", "sk:drivingPose") == Pose.of(-0.78, 0, 0)
    assert mine.class_value("mine:Bin", "sk:drivingPose") == Pose.of(-0.78, 0, 0)
    assert (mine.class_value("kitting:Pallet", "sk:mass"), mine.class_value("mine:Bin", "sk:mass")) == (0.0, 3.0)


def test_a_bare_name_is_resolved_where_it_is_unambiguous(ontology: Ontology, root: Path, tmp_path: Path) -> None:
    assert ontology.resolve_class("Starter") == ontology.resolve_class("kitting:Starter") == "kitting:Starter"
    assert ontology.resolve_relation("heldBy") == "sk:heldBy"
    with pytest.raises(UnknownName, match="Did you mean 'Starter'"):
        ontology.resolve_class("Startr")
    twice = load_with(root, tmp_path, "mine:Starter a owl:Class ; rdfs:subClassOf sk:Object .")
    with pytest.raises(UsageError, match="kitting:Starter, mine:Starter"):
        twice.resolve_class("Starter")


@pytest.mark.parametrize(
    ("text", "line", "says"),
    [
        ("mine:A a owl:Class ;\n  rdfs:subClassOf sk:Objt .", 6, "unknown class 'sk:Objt'. Did you mean 'sk:Object'"),
        ("mine:A a owl:Class\n  rdfs:label 'a' .", 6, "not Turtle at column"),
        ("# mine:A\nmine:A a owl:Class ; rdfs:subClassOf mine:A .", 6, "above itself"),
        ("mine:A a owl:Class ; rdfs:subClassOf sk:Object ;\n sk:mas 3 .", 6, "Did you mean 'sk:mass'"),
        ("mine:A a owl:Class ; rdfs:subClassOf sk:Object ;\n sk:mass 'x' .", 6, "needs a finite number"),
        ("mine:at a owl:ObjectProperty ; rdfs:subPropertyOf sk:placement .", 5, "needs sk:placeEnd"),
        ("mine:p a owl:DatatypeProperty ;\n rdfs:range sk:poseLitral .", 6, "Did you mean 'sk:poseLiteral'"),
    ],
)
def test_a_wrong_declaration_is_refused_with_its_line(
    root: Path, tmp_path: Path, text: str, line: int, says: str
) -> None:
    with pytest.raises(FileError) as caught:
        load_with(root, tmp_path, text)

    assert says in caught.value.reason
    assert (caught.value.path, caught.value.line) == (tmp_path / "mine.ttl", line)


def test_a_prefix_that_stands_for_two_iris_is_refused(root: Path, tmp_path: Path) -> None:
    with pytest.raises(FileError, match="prefix 'kitting:' stands for"):
        load_with(root, tmp_path, "@prefix kitting: <https://example.org/other#> .")


def test_a_missing_file_is_named() -> None:
    with pytest.raises(FileError, match=r"nowhere\.ttl: there is no such file"):
        Ontology.load([Path("nowhere.ttl")])


def test_every_term_of_the_vocabulary_is_declared(ontology: Ontology) -> None:
    declared = {*ontology.classes, *ontology.relations, *ontology.properties, "rdfs:label"}

    assert {value for name, value in vars(vocabulary).items() if name.isupper()} <= declared


def test_every_term_has_a_label_and_a_comment(ontology: Ontology) -> None:
    terms = [*ontology.classes.values(), *ontology.relations.values(), *ontology.properties.values()]

    assert [term.curie for term in terms if not term.label or not term.comment] == []
