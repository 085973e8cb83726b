"""Plans with things that are only counted: any of them will do, and never more are looked at than can be used."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skiros_py.planning.plan import NoPlan, Plan
from skiros_py.planning.problem.stock import believed, tokens_of, with_stock
from skiros_py.planning.service import Planned
from skiros_py.skills.conditions import Compare, ConditionType, Related, Role
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.goals import parse_goal
from skiros_py.testing import CONDITIONS, Bench, tiny_world
from skiros_py.testing.tiny import pretend
from skiros_py.world.stock import Stocked
from skiros_py.world.view import WorldView
from skiros_py.world.world import World

LIES = ConditionType("Lies", (Role("key", "tiny:Key"), Role("box", "tiny:Box")), Related("sk:in", "key", "box"), "-")
STUCK = ConditionType(
    "Stuck", (Role("key", "tiny:Key"), Role("door", "tiny:Door")), Related("sk:on", "key", "door"), "-"
)
OPEN = ConditionType("Open", (Role("door", "tiny:Door"),), Compare("tiny:opening", "=", "door", "open"), "-")
UNLOCK = SkillDescription(
    name="unlock",
    help="Opens a door with a key that is stuck in it from then on.",
    agent="Arm",
    target="Door",
    params=(
        Param("Arm", "sk:Arm", "Who opens it.", Kind.HARDWARE),
        Param("Box", "tiny:Box", "Where the key lies."),
        Param("Key", "tiny:Key", "The key."),
        Param("Door", "tiny:Door", "The door."),
    ),
    pre=(LIES("Key", "Box"),),
    post=(STUCK("Key", "Door"), OPEN("Door")),
)
TWO = ("In(RedBall, slot_1)", "In(RedBall, slot_2)")


def stock(count: int, class_: str = "tiny:RedBall", place: str = "box_a", name: str = "reds") -> str:
    described = f'scene:{name} a sk:Stock ; sk:stockOf "{class_}" ; sk:stockCount {count} .'
    return f"scene:{place} sk:hasA scene:{name} . {described}"


def stocked(world: World, *goal: str, named: tuple[str, ...] = (), whole: bool = False) -> WorldView:
    return with_stock(world, parse_goal(goal, world, CONDITIONS), named, whole=whole)


def planned(world: World, *goal: str) -> Planned:
    with Bench(world) as bench:
        return bench.plan(*goal)


def slots(number: int) -> str:
    return "".join(f"scene:slot_{n} a tiny:Slot ; sk:on scene:floor .\n" for n in range(3, number + 1))


def test_a_world_without_stock_is_planned_with_as_it_is() -> None:
    world = tiny_world()

    assert stocked(world, *TWO) is world


def test_a_plan_can_use_a_thing_that_is_only_counted_in_stock() -> None:
    outcome = planned(tiny_world(stock(3, "tiny:Giant", name="giants"), stock(3)), "In(RedBall, slot_1)").outcome

    assert isinstance(outcome, Plan)
    assert [step.skill for step in outcome.steps] == ["drive", "pick", "place"]
    assert tokens_of(outcome.steps) in ((), ("reds#1",))


def test_each_condition_gets_a_thing_of_its_own() -> None:
    world = tiny_world(stock(2))
    with world.transaction("ann", "away") as tx:
        tx.remove("red_ball_1")

    outcome = planned(world, *TWO).outcome

    assert isinstance(outcome, Plan)
    assert sorted(tokens_of(outcome.steps)) == ["reds#1", "reds#2"]


def test_planning_from_stock_does_not_change_the_world() -> None:
    world = tiny_world(stock(2))
    before = world.version

    with Bench(world) as bench:
        began = world.version
        bench.plan(*TWO)

        assert world.version == began >= before


@pytest.mark.parametrize(
    ("goal", "shown"),
    [
        (("In(RedBall, slot_1)",), 3),
        (TWO, 4),
        (("In(Ball, slot_1)",), 3),
        (("In(Giant, slot_1)",), 2),
        (("In(ball_1, slot_1)",), 2),
        (("for all s: Slot (exists b: Ball (In(b, s)))",), 4),
        (("for all b: Ball (In(b, box_b))",), 50),
        (("not In(RedBall, box_a)",), 50),
        (("Free(slot_1)",), 50),
    ],
)
def test_a_stock_offers_as_many_tokens_as_the_goal_needs(goal: tuple[str, ...], shown: int) -> None:
    view = stocked(tiny_world(stock(50)), *goal)

    assert isinstance(view, Stocked)
    assert len(view.further) == shown


def test_a_stock_never_offers_more_tokens_than_it_has_and_a_large_one_only_some() -> None:
    few, many = stocked(tiny_world(stock(1)), *TWO), stocked(tiny_world(stock(1_000_000)), "not In(RedBall, box_a)")

    assert isinstance(few, Stocked)
    assert isinstance(many, Stocked)
    assert few.further == ("reds#1",)
    assert not few.short
    assert len(many.further) == 100
    assert many.short


def test_a_plan_may_use_more_stock_than_the_goal_mentions() -> None:
    """Things that are spent on the way: four doors, each opened with a key that stays in the lock."""
    doors = "".join(f"scene:door_{n} a tiny:Door ; sk:on scene:floor .\n" for n in range(1, 5))
    world = tiny_world(stock(5, "tiny:Key", name="keys"), doors)
    with Bench(world, (pretend(UNLOCK),), conditions={OPEN.name: OPEN}) as bench:
        outcome = bench.plan(*(f"Open(door_{n})" for n in range(1, 5))).outcome

    assert isinstance(outcome, Plan)
    assert len(tokens_of(outcome.steps)) == 4


def test_tokens_named_in_a_plan_are_offered_as_long_as_stock_is_left() -> None:
    enough, short = (stocked(tiny_world(stock(n)), named=("reds#7", "reds#9")) for n in (2, 1))

    assert isinstance(enough, Stocked)
    assert isinstance(short, Stocked)
    assert enough.further == ("reds#7", "reds#9")
    assert short.further == ("reds#7",)


def test_a_stock_shortage_is_reported_and_one_more_item_is_enough() -> None:
    world = tiny_world(stock(1), slots(3))

    outcome = planned(world, *TWO, "In(RedBall, slot_3)").outcome

    assert isinstance(outcome, NoPlan)
    assert "3 of RedBall are wanted, but there are only red_ball_1 and 1 of stock reds" in outcome.reasons[0]
    assert any("bring one more RedBall" in repair.text for repair in outcome.repairs)


def test_stock_items_fulfil_a_goal_about_their_class() -> None:
    world = tiny_world(stock(2))
    here, there = parse_goal(("In(RedBall, box_a)", "not In(RedBall, box_a)"), world, CONDITIONS)

    assert believed(here, world)
    assert not believed(there, world)
    assert planned(world, "In(RedBall, box_a)").outcome == Plan(())


def test_a_place_with_stock_is_not_empty() -> None:
    world = tiny_world(stock(1, place="slot_1"))

    assert isinstance(planned(world, "In(ball_1, slot_1)").outcome, NoPlan)


@pytest.mark.parametrize("goal", ["for all s: Slot (In(RedBall, s))", "for all s: Slot (exists b: RedBall (In(b, s)))"])
def test_a_goal_about_each_place_uses_as_many_things_of_a_stock_as_there_are_places(goal: str) -> None:
    enough, short = (planned(tiny_world(stock(count), slots(4)), goal).outcome for count in (3, 2))

    assert isinstance(enough, Plan)
    assert len(tokens_of(enough.steps)) == 3
    assert isinstance(short, NoPlan)
    assert "4 of RedBall are wanted, but there are only red_ball_1 and 2 of stock reds" in short.reasons[0]


def test_a_plan_may_use_up_all_of_a_stock_that_a_plan_can_handle() -> None:
    doors = "".join(f"scene:door_{n} a tiny:Door ; sk:on scene:floor .\n" for n in range(1, 21))
    world = tiny_world(stock(20, "tiny:Key", name="keys"), doors)
    with Bench(world, (pretend(UNLOCK),), conditions={OPEN.name: OPEN}) as bench:
        outcome = bench.plan("for all d: Door (Open(d))").outcome

    assert isinstance(outcome, Plan)
    assert len(tokens_of(outcome.steps)) == 20


@settings(max_examples=25, deadline=None)
@given(st.integers(1, 4), st.integers(0, 5), st.integers(0, 3))
def test_a_plan_exists_exactly_if_individuals_and_stock_suffice(wanted: int, count: int, known: int) -> None:
    reds = "".join(f"scene:red_ball_{n} a tiny:RedBall ; sk:in scene:box_b .\n" for n in range(2, known + 1))
    world = tiny_world(stock(count), slots(4), reds)
    if not known:
        with world.transaction("ann", "away") as tx:
            tx.remove("red_ball_1")

    outcome = planned(world, *(f"In(RedBall, slot_{n})" for n in range(1, wanted + 1))).outcome

    assert isinstance(outcome, Plan) == (wanted <= count + known)
    if isinstance(outcome, Plan):
        assert len(tokens_of(outcome.steps)) >= wanted - known
