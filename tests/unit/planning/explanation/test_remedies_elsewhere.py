"""Two things for one place: that is said first, and another place is offered before anything is given up."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from support.planning import tiny_task

from skiros_py.planning.explanation.explaining import explain
from skiros_py.planning.explanation.trial import Trial
from skiros_py.planning.plan import CauseKind, NoPlan
from skiros_py.planning.planners.kairos import Kairos
from skiros_py.planning.planners.planner import Planners
from skiros_py.planning.problem.task import Capability
from skiros_py.tasks.goals import parse_goal
from skiros_py.testing import CONDITIONS, tiny_world
from skiros_py.testing.tiny import DRIVE, PICK, PLACE
from skiros_py.world.world import World

IN_SLOT_1 = "scene:ball_1 sk:in scene:slot_1 ."


@pytest.fixture(scope="module")
def planners() -> Iterator[Planners]:
    found = Planners.only(Kairos())
    yield found
    found.close()


def explained(planners: Planners, *goal: str, facts: tuple[str, ...] = ()) -> NoPlan:
    return explained_in(tiny_world(*facts), planners, *goal)


def explained_in(world: World, planners: Planners, *goal: str) -> NoPlan:
    able = [Capability(skill, world.instances(skill.agent_class)) for skill in (DRIVE, PICK, PLACE)]
    conditions = parse_goal(list(goal), world, CONDITIONS)
    trial = Trial(planners, able, each=30.0, together=300.0)
    return explain(tiny_task(world, *conditions), trial)


def texts(found: NoPlan) -> list[str]:
    return [repair.text for repair in found.repairs]


def test_each_thing_is_offered_a_free_place_before_one_is_given_up(planners: Planners) -> None:
    found = explained(planners, "In(ball_1, slot_1)", "In(red_ball_1, slot_1)")

    assert texts(found) == [
        "want In(ball_1, slot_2) instead of In(ball_1, slot_1)",
        "want In(red_ball_1, slot_2) instead of In(red_ball_1, slot_1)",
        "give up In(ball_1, slot_1)",
        "give up In(red_ball_1, slot_1)",
    ]


def test_moving_a_thing_and_giving_up_one_condition_comes_before_giving_up_both(planners: Planners) -> None:
    there = "scene:ball_9 a tiny:Ball ; sk:in scene:slot_1 ."

    found = explained(planners, "In(ball_1, slot_1)", "In(red_ball_1, slot_1)", "Free(slot_2)", facts=(there,))

    assert texts(found)[0] == "put ball_9 in box_a and give up In(ball_1, slot_1)"
    assert [len(repair.without) for repair in found.repairs if not repair.edits] == [2]


def test_another_place_and_one_more_thing_are_offered_before_something_is_given_up(planners: Planners) -> None:
    world = tiny_world()
    with world.transaction("test", "no red ball") as tx:
        tx.remove("red_ball_1")

    found = explained_in(world, planners, "In(RedBall, slot_1)", "In(ball_1, slot_1)")

    more = "and bring one more RedBall, in box_a"
    assert texts(found) == [
        f"want In(RedBall, slot_2) instead of In(RedBall, slot_1) {more}",
        f"want In(ball_1, slot_2) instead of In(ball_1, slot_1) {more}",
        "give up In(RedBall, slot_1)",
    ]


@pytest.mark.parametrize("other", ["red_ball_1", "RedBall"])
def test_that_a_place_takes_only_one_thing_is_the_first_cause_even_if_it_is_occupied(
    other: str, planners: Planners
) -> None:
    """Whoever is told that it has to be taken away would take away what is wanted there."""
    there = "scene:ball_9 a tiny:Ball ; sk:in scene:slot_1 ."

    found = explained(planners, "In(ball_9, slot_1)", f"In({other}, slot_1)", facts=(there,))

    assert [cause.kind for cause in found.causes[:1]] == [CauseKind.CONTRADICTION]
    assert found.causes[0].why == "slot_1 takes one ball only"
    assert texts(found)[0] == f"want In({other}, slot_2) instead of In({other}, slot_1)"
    assert not [repair for repair in found.repairs if repair.edits]


def test_an_occupied_place_is_named_as_a_further_cause(planners: Planners) -> None:
    there = "scene:ball_9 a tiny:Ball ; sk:in scene:slot_1 ."

    found = explained(planners, "In(ball_1, slot_1)", "In(red_ball_1, slot_1)", facts=(there,))

    assert [cause.kind for cause in found.causes] == [CauseKind.CONTRADICTION, CauseKind.FULL, CauseKind.FULL]
    assert found.causes[1].why == "ball_9 is in slot_1, and no skill takes it away"


def test_places_that_are_occupied_or_named_in_the_goal_are_not_offered(planners: Planners) -> None:
    there = "scene:ball_9 a tiny:Ball ; sk:in scene:slot_2 ."
    wanted = "In(ball_1, slot_1)", "In(red_ball_1, slot_1)"

    assert not any(repair.instead for repair in explained(planners, *wanted, facts=(there,)).repairs)
    assert not any(repair.instead for repair in explained(planners, *wanted, "Free(slot_2)").repairs)


def test_a_goal_that_wants_a_place_free_offers_no_other_place(planners: Planners) -> None:
    there = "scene:ball_9 a tiny:Ball ; sk:in scene:slot_1 ."

    found = explained(planners, "Free(slot_1)", facts=(there,))

    assert texts(found) == ["put ball_9 in box_a", "remove ball_9 from the scene"]


def test_a_place_of_the_wrong_class_is_reported_with_a_suitable_one(planners: Planners) -> None:
    found = explained(planners, "In(ball_1, box_b)")

    assert found.causes[0].kind is CauseKind.NO_SKILL
    assert found.repairs[0].instead[0].as_json() == {"condition": "In(ball_1, box_b)", "by": "In(ball_1, slot_1)"}


def test_a_repair_lists_its_names_as_data(planners: Planners) -> None:
    there = "scene:ball_9 a tiny:Ball ; sk:in scene:slot_1 ."

    found = explained(planners, "In(ball_1, slot_1)", facts=(there,))

    data = {repair.text: repair.as_json() for repair in found.repairs}
    assert data["put ball_9 in box_a"]["elements"] == ["ball_9", "box_a"]
