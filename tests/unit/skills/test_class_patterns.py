from __future__ import annotations

from pathlib import Path

import pytest

from skiros_py.config import ontology_paths
from skiros_py.errors import UnknownName
from skiros_py.skills.conditions import ClassRelated, IsA, Not, Verdict
from skiros_py.testing import TINY_ONTOLOGY, tiny_scene, tiny_world
from skiros_py.world.ontology import Ontology
from skiros_py.world.scene.files import load_scene
from skiros_py.world.world import World

MORE = """\
@prefix more: <https://example.org/more#> .
@prefix scene: <https://w3id.org/skiros-py/scene#> .
@prefix tiny: <https://w3id.org/skiros-py/testing/tiny#> .
@prefix owl: <http://www.w3.org/2002/07/owl#> .
@prefix rdfs: <http://www.w3.org/2000/01/rdf-schema#> .
<https://example.org/more> a owl:Ontology ; owl:imports <https://w3id.org/skiros-py/testing/tiny> .
more:opens a owl:ObjectProperty ; rdfs:subPropertyOf tiny:madeFor ; rdfs:label "opens" .
more:HouseKey a owl:Class ; rdfs:label "house key" ; rdfs:subClassOf tiny:Key ,
    [ a owl:Restriction ; owl:onProperty more:opens ; owl:hasValue scene:box_a ] .
more:AnyKey a owl:Class ; rdfs:label "any key" ; rdfs:subClassOf tiny:Ball ,
    [ a owl:Restriction ; owl:onProperty more:opens ; owl:someValuesFrom owl:Thing ] .
"""
KEYS = (
    "scene:key_1 a tiny:Key ; sk:on scene:floor . scene:toy_key_1 a tiny:ToyKey ; sk:on scene:floor .",
    "scene:door_1 a tiny:Door ; sk:on scene:floor .",
)
MADE_FOR = ClassRelated("tiny:madeFor", "key", "thing")


def more_world(folder: Path, *facts: str) -> World:
    (folder / "more.ttl").write_text(MORE, encoding="utf-8")
    ontology = Ontology.load((ontology_paths()[0] / "core.ttl", TINY_ONTOLOGY, folder / "more.ttl"))
    prefix = "@prefix more: <https://example.org/more#> ."
    return load_scene(ontology, tiny_scene(folder, prefix, *KEYS, *facts))


def made_for(world: World, key: str, thing: str) -> Verdict:
    return MADE_FOR.evaluate(world, {"key": key, "thing": thing})


def test_an_element_is_of_its_class_and_of_those_above_it() -> None:
    world = tiny_world()

    assert IsA("it", "tiny:RedBall").evaluate(world, {"it": "red_ball_1"})
    assert IsA("it", "sk:Manipulatable").evaluate(world, {"it": "red_ball_1"})
    verdict = IsA("it", "tiny:RedBall").evaluate(world, {"it": "ball_1"})
    assert (verdict.holds, verdict.text) == (False, "ball_1 is a Ball, not a RedBall")


def test_an_undeclared_class_is_an_error_that_names_it() -> None:
    with pytest.raises(UnknownName, match="tiny:Bal"):
        IsA("it", "tiny:Bal").evaluate(tiny_world(), {"it": "ball_1"})


def test_class_restrictions_state_the_purpose_of_a_class() -> None:
    world = tiny_world(*KEYS)

    assert made_for(world, "key_1", "door_1").text == "a Key madeFor a Door, as door_1 is one"
    assert made_for(world, "toy_key_1", "box_a")
    assert made_for(world, "key_1", "box_a").text == "a Key madeFor Door, and box_a is a Box"
    assert not made_for(world, "toy_key_1", "door_1")


def test_a_class_pattern_fails_for_a_class_without_restrictions() -> None:
    verdict = made_for(tiny_world(), "ball_1", "box_a")

    assert (verdict.holds, verdict.text) == (False, "a Ball madeFor nothing that is said, and box_a is a Box")
    assert Not(MADE_FOR).evaluate(tiny_world(), {"key": "ball_1", "thing": "box_a"})


def test_restrictions_of_superclasses_and_subrelations_count(tmp_path: Path) -> None:
    world = more_world(tmp_path, "scene:house_key_1 a more:HouseKey ; sk:on scene:floor .")

    assert made_for(world, "house_key_1", "door_1"), "it is a key"
    assert made_for(world, "house_key_1", "box_a"), "this one box"
    assert not made_for(world, "house_key_1", "box_b")


def test_a_restriction_without_a_class_matches_any_element(tmp_path: Path) -> None:
    world = more_world(tmp_path, "scene:any_key_1 a more:AnyKey ; sk:on scene:floor .")

    assert made_for(world, "any_key_1", "slot_1")


def test_an_undeclared_relation_is_an_error_that_names_it() -> None:
    with pytest.raises(UnknownName, match="tiny:madefor"):
        ClassRelated("tiny:madefor", "a", "b").evaluate(tiny_world(), {"a": "ball_1", "b": "box_a"})
