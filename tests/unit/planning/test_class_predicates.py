from __future__ import annotations

from support.planning import tiny_task

from skiros_py.planning.domain.literals import common_class, primary_line, with_class_predicates
from skiros_py.planning.domain.model import Action, Atom, NoneSuch, Variable
from skiros_py.testing import Bench, tiny_ontology, tiny_world
from skiros_py.testing.tiny import IN_CONTAINER

BENCH = "scene:bench_1 a tiny:Bench ; sk:on scene:floor . scene:ball_5 a tiny:Ball ; sk:in scene:bench_1 ."


def test_the_primary_ancestors_follow_primary_parents_only() -> None:
    line = primary_line(tiny_ontology(), "tiny:Bench")

    assert line[0] == "sk:Furniture"
    assert "tiny:Box" not in line


def test_the_common_class_is_the_nearest_shared_ancestor() -> None:
    ontology = tiny_ontology()

    assert common_class("tiny:Ball", "tiny:RedBall", ontology) == "tiny:Ball"
    assert common_class("tiny:Box", "tiny:Slot", ontology) == "sk:Container"
    assert common_class("tiny:Box", "", ontology) == "tiny:Box"
    assert common_class("tiny:Box", "object", ontology) == "object"


def test_without_second_parents_in_the_scene_classes_are_types_only() -> None:
    domain = tiny_task(tiny_world(), IN_CONTAINER("ball_1", "slot_1")).domain

    assert not [name for name in domain.predicates if name.startswith("is ")]


def test_membership_by_a_second_parent_is_a_predicate() -> None:
    task = tiny_task(tiny_world(BENCH), IN_CONTAINER("ball_1", "slot_1"))
    pick = next(action for action in task.domain.actions if action.name == "pick")

    assert Atom("is tiny:Box", ("?Box",)) in pick.pre
    assert Variable("?Box", "sk:SpatialThing") in pick.parameters
    members = {atom.arguments[0] for atom in task.problem.init if atom.predicate == "is tiny:Box"}
    assert members == {"bench_1", "box_a", "box_b"}


def test_absence_conditions_use_the_class_predicate_too() -> None:
    none = NoneSuch((Variable("?b", "tiny:Box"),), (Atom("sk:in", ("?x", "?b")),))
    action = Action("look", "look", (Variable("?x", "tiny:Ball"),), (), (), (), none=(none,))

    (widened,) = with_class_predicates([action], {"bench_1": "tiny:Bench", "box_a": "tiny:Box"}, tiny_ontology())

    wider = (Variable("?b", "sk:SpatialThing"),)
    assert widened.none == (NoneSuch(wider, (Atom("is tiny:Box", ("?b",)), Atom("sk:in", ("?x", "?b")))),)


def test_an_object_is_listed_once_under_its_own_class() -> None:
    task = tiny_task(tiny_world(BENCH), IN_CONTAINER("ball_1", "slot_1"))

    assert task.problem.objects["bench_1"] == "tiny:Bench"
    assert task.domain.types["tiny:Bench"] == "sk:SpatialThing"


def test_a_robot_picks_from_furniture_that_is_also_a_box() -> None:
    with Bench(tiny_world(BENCH)) as bench:
        report = bench.pursue("In(ball_5, slot_1)")

    assert report.reached
    assert report.steps[1].arguments["Box"] == "bench_1"
