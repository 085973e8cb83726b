"""Goals with and, or, not, for all and exists in any nesting: true of the task where they are true of the world."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.planning import tiny_task

from skiros_py.planning.domain.goals import REACHED
from skiros_py.planning.domain.model import Atom
from skiros_py.planning.plan import NoPlan, Plan
from skiros_py.planning.plan_validation import TaskState
from skiros_py.planning.problem.task import PlanningTask
from skiros_py.skills.conditions import (
    AllOf,
    AnyOf,
    Condition,
    ConditionType,
    Exists,
    Has,
    IsA,
    Not,
    Nothing,
    Pattern,
    Related,
    Role,
)
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import CONDITIONS

FACTS = (
    "scene:ball_2 a tiny:Ball ; tiny:scanned true ; sk:in scene:slot_2 .",
    "scene:box_c a tiny:Box ; sk:on scene:floor .",
)
WORLD = tiny_world(*FACTS)
BALLS, PLACES = ("ball_1", "ball_2", "red_ball_1"), ("box_a", "box_b", "box_c", "slot_1", "slot_2")
ROLES = (*(Role(ball, "tiny:Ball") for ball in BALLS), *(Role(place, "sk:Container") for place in PLACES))


def said(pattern: Pattern) -> Condition:
    """Returns a condition over the elements of the scene, each under its own name."""
    return ConditionType("Said", ROLES, pattern, "-")(*BALLS, *PLACES)


def literals(balls: tuple[str, ...], places: tuple[str, ...]) -> st.SearchStrategy[Pattern]:
    ball, place = st.sampled_from(balls), st.sampled_from(places)
    return st.one_of(
        st.builds(lambda b, p: Related("sk:in", b, p), ball, place),
        st.builds(lambda b, p: Related("sk:placement", b, p), ball, place),
        st.builds(lambda p: Nothing("sk:in", p), place),
        st.builds(lambda b: Has("tiny:scanned", b), ball),
        st.builds(lambda b: IsA(b, "tiny:RedBall"), ball),
    )


def patterns(
    depth: int, balls: tuple[str, ...] = BALLS, places: tuple[str, ...] = PLACES
) -> st.SearchStrategy[Pattern]:
    plain = literals(balls, places)
    if depth == 0:
        return plain
    inner = patterns(depth - 1, balls, places)
    ball, place = f"b{depth}", f"p{depth}"
    return st.one_of(
        plain,
        inner.map(Not),
        st.lists(inner, min_size=1, max_size=3).map(lambda parts: AllOf(tuple(parts))),
        st.lists(inner, min_size=1, max_size=3).map(lambda parts: AnyOf(tuple(parts))),
        patterns(depth - 1, (*balls, ball), places).map(lambda p: Exists(ball, "tiny:Ball", p)),
        patterns(depth - 1, balls, (*places, place)).map(lambda p: Exists(place, "sk:Container", p)),
    )


def holds_at_once(task: PlanningTask) -> bool:
    """Tells whether bookkeeping alone leads to the goal: nothing has to be done."""
    return TaskState(task).close() is not None


@settings(max_examples=300, deadline=None)
@given(patterns(3))
def test_a_nested_goal_needs_an_empty_plan_exactly_if_it_holds(pattern: Pattern) -> None:
    goal = said(pattern)

    assert holds_at_once(tiny_task(WORLD, goal)) == bool(goal.evaluate(WORLD))


def chain(depth: int) -> Pattern:
    """Returns a nesting whose disjunctive form has 2 to the power of the depth parts."""
    either = AnyOf((Related("sk:in", "ball_1", "box_a"), Related("sk:in", "ball_1", "box_b")))
    pattern: Pattern = either
    for _ in range(depth):
        pattern = AllOf((AnyOf((pattern, Related("sk:in", "ball_2", "box_a"))), either))
    return pattern


def size(task: PlanningTask) -> int:
    return sum(len(action.pre) for action in task.domain.actions if action.skill is None)


def test_a_task_grows_with_the_goal_and_not_with_its_combinations() -> None:
    sizes = [size(tiny_task(WORLD, said(chain(depth)))) for depth in (10, 20, 30)]

    assert sizes[2] - sizes[1] == sizes[1] - sizes[0]


def test_nested_for_all_is_expanded_once_per_element_and_not_per_pair() -> None:
    def pairs(balls: int) -> PlanningTask:
        world = tiny_world(*(f"scene:b_{i} a tiny:Ball ; sk:in scene:box_a ." for i in range(balls)))
        together = AnyOf((Related("sk:in", "x", "p"), Has("tiny:scanned", "y")))
        inner = Not(Exists("y", "tiny:Ball", Not(Exists("p", "tiny:Box", together))))
        word = ConditionType("All", (), Not(Exists("x", "tiny:Ball", Not(inner))), "-")
        return tiny_task(world, word())

    sizes = [size(pairs(n)) + len(pairs(n).problem.goal) for n in (10, 20, 30)]

    assert sizes[2] - sizes[1] == sizes[1] - sizes[0]


def test_conditions_that_no_skill_makes_false_are_not_required() -> None:
    task = tiny_task(WORLD, said(Nothing("sk:in", "box_a")))

    assert task.problem.goal == (Atom("not sk:in", ("ball_1", "box_a")),), "nothing else is there, or gets there"


def test_each_part_of_a_goal_has_its_own_facts() -> None:
    either = AnyOf((Related("sk:in", "ball_1", "slot_1"), Related("sk:in", "ball_2", "slot_1")))
    other = Exists("b", "tiny:Ball", Related("sk:in", "b", "slot_2"))

    goal = tiny_task(WORLD, said(AllOf((either, other)))).problem.goal

    assert goal == (Atom(f"{REACHED}1"), Atom(f"{REACHED}1.1"))


IN_SLOT = Exists("s", "tiny:Slot", Related("sk:in", "b", "s"))
DONE = [
    pytest.param(
        Not(Exists("b", "tiny:RedBall", Not(IN_SLOT))), ["drive", "pick", "place"], id="every red ball stored"
    ),
    pytest.param(Not(Exists("b", "tiny:Ball", Related("sk:in", "b", "box_b"))), ["drive", "pick"], id="box emptied"),
    pytest.param(
        AnyOf((AllOf((Related("sk:in", "ball_1", "slot_2"), Nothing("sk:in", "box_b"))), Nothing("sk:in", "box_a"))),
        ["drive", "pick"],
        id="the way that is possible",
    ),
    pytest.param(
        Exists("b", "tiny:RedBall", AllOf((IN_SLOT, Not(Related("sk:in", "b", "slot_2"))))),
        ["drive", "pick", "place"],
        id="in a slot but not in that one",
    ),
]


@pytest.mark.parametrize(("pattern", "steps"), DONE)
def test_nested_goals_are_planned_for(pattern: Pattern, steps: list[str]) -> None:
    word = ConditionType("Done", ROLES, pattern, "-")
    with Bench(tiny_world(*FACTS), conditions={**CONDITIONS, "Done": word}) as bench:
        outcome = bench.plan(f"Done({', '.join((*BALLS, *PLACES))})").outcome

    assert isinstance(outcome, Plan), outcome
    assert [step.skill for step in outcome.steps] == steps


def test_an_unreachable_goal_for_all_has_no_plan() -> None:
    every = Not(Exists("b", "tiny:Ball", Not(Related("sk:in", "b", "slot_1"))))
    word = ConditionType("AllThere", (Role("slot_1", "tiny:Slot"),), every, "-")
    with Bench(tiny_world(), conditions={**CONDITIONS, "AllThere": word}) as bench:
        assert isinstance(bench.plan("AllThere(slot_1)").outcome, NoPlan)
