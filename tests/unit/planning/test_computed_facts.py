from __future__ import annotations

from dataclasses import replace

from support.planning import tiny_task

from skiros_py.planning.domain.model import Atom
from skiros_py.planning.plan import NoPlan
from skiros_py.skills.conditions import Computed, ConditionType, Role
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import DRIVE, IN_CONTAINER, PICK, PLACE, pretend

NEAR = ConditionType(
    "Near", (Role("ball", "tiny:Ball"), Role("slot", "tiny:Slot")), Computed("sk:near", "ball", "slot"), "Close by."
)
PLACE_NEAR = replace(PLACE, pre=(*PLACE.pre, NEAR("Ball", "Slot")))


def at(element: str, x: float) -> str:
    return f'scene:{element} sk:pose "{x} 0 0 0 0 0"^^sk:poseLiteral .'


FACTS = at("ball_1", 0.0), at("slot_1", 2.0), at("slot_2", 0.3)


def test_each_pair_of_a_computed_relation_is_a_fact_of_the_problem() -> None:
    task = tiny_task(tiny_world(*FACTS), IN_CONTAINER("ball_1", "slot_2"), skills=(DRIVE, PICK, PLACE_NEAR))

    near = {atom for atom in task.problem.init if atom.predicate == "sk:near"}
    assert near == {Atom("sk:near", ("ball_1", "slot_2"))}


def test_a_plan_exists_only_if_the_computed_relation_holds() -> None:
    with Bench(tiny_world(*FACTS), [pretend(skill) for skill in (DRIVE, PICK, PLACE_NEAR)]) as bench:
        assert not isinstance(bench.plan("In(ball_1, slot_2)").outcome, NoPlan)
        assert isinstance(bench.plan("In(ball_1, slot_1)").outcome, NoPlan)
