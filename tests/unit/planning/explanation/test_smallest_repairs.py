"""What repairs do: no more than is needed, to places that have room, and such that they can be applied."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from mutations import IN_TRAY
from support.planning import tiny_task

from skiros_py.planning.edits import Move
from skiros_py.planning.explanation.causes import find_causes
from skiros_py.planning.explanation.explaining import explain, find_repairs
from skiros_py.planning.explanation.trial import Trial
from skiros_py.planning.plan import NoPlan
from skiros_py.planning.planners.kairos import Kairos
from skiros_py.planning.planners.planner import Planners
from skiros_py.planning.problem.task import Capability
from skiros_py.tasks.goals import parse_goal
from skiros_py.testing import CONDITIONS, tiny_world
from skiros_py.testing.tiny import DRIVE, PICK, PLACE
from skiros_py.world.view import WorldView
from skiros_py.world.world import World

WORDS = {**CONDITIONS, "InTray": IN_TRAY}
TRAY = (
    "scene:tray_1 a sk:Container ; sk:on scene:floor ; sk:hasA scene:tray_1_1 , scene:tray_1_2 .",
    "scene:tray_1_1 a tiny:Slot . scene:tray_1_2 a tiny:Slot .",
)


@pytest.fixture(scope="module")
def planners() -> Iterator[Planners]:
    found = Planners.only(Kairos())
    yield found
    found.close()


def able(world: WorldView) -> list[Capability]:
    return [Capability(skill, world.instances(skill.agent_class)) for skill in (DRIVE, PICK, PLACE)]


def trial(world: World, planners: Planners) -> Trial:
    return Trial(planners, able(world), each=30.0, together=300.0)


def explained(world: World, planners: Planners, *goal: str) -> NoPlan:
    conditions = parse_goal(list(goal), world, WORDS)
    return explain(tiny_task(world, *conditions), trial(world, planners))


def ball(number: int, place: str) -> str:
    return f"scene:ball_{number} a tiny:Ball ; sk:in scene:{place} ."


def test_a_repair_puts_a_thing_into_its_storage_and_never_into_a_place_for_one(planners: Planners) -> None:
    """The other balls lie in slots: in full ones, and one that is free."""
    world = tiny_world(*TRAY, ball(8, "tray_1_1"), ball(9, "tray_1_2"))

    found = explained(world, planners, "Free(tray_1_1)")

    assert found.repairs[0].text == "put ball_8 in box_a"
    places = {edit.place for repair in found.repairs for edit in repair.edits if isinstance(edit, Move)}
    assert places == {"box_a"}


@pytest.mark.parametrize(
    ("goal", "reason"),
    [
        ("not InTray(ball_8, tray_1)", "ball_8 is in tray_1_1, and no skill takes it from there"),
        ("not In(ball_8, tray_1_1)", "tray_1_1 is not a Box, which skill 'pick' needs"),
    ],
)
def test_a_thing_at_a_place_without_a_removing_skill_is_put_elsewhere(
    goal: str, reason: str, planners: Planners
) -> None:
    found = explained(tiny_world(*TRAY, ball(8, "tray_1_1")), planners, goal)

    assert reason in found.reasons[0]
    assert found.repairs[0].text == "put ball_8 in box_a"


def test_parts_without_room_may_be_removed_from_the_scene(planners: Planners) -> None:
    world = tiny_world(*TRAY, *(ball(n, "box_a") for n in (8, 9)))

    found = explained(world, planners, "for all b: Ball (InTray(b, tray_1))")

    assert all(len(repair.edits) == 2 for repair in found.repairs)
    assert found.repairs[0].text == "remove ball_1 from the scene and remove ball_8 from the scene"


def test_a_repair_does_not_change_the_elements_it_adds(planners: Planners) -> None:
    """It is brought to where it hinders something else: its name is known only when it is there."""
    world = tiny_world(*TRAY, ball(8, "tray_1_1"))
    with world.transaction("test", "only one ball, in a slot") as tx:
        tx.remove("ball_1")
        tx.remove("red_ball_1")

    found = explained(world, planners, "In(Giant, box_a) or In(RedBall, slot_1)", "Free(tray_1_2)", "Free(tray_1_1)")

    there = set(world.instances("sk:Element"))
    assert found.repairs
    assert all(there.issuperset(edit.elements) for repair in found.repairs for edit in repair.edits)


def test_unneeded_changes_are_left_out_of_a_repair(planners: Planners) -> None:
    """The search begins with a cause that is none: what is done about it is of no use."""
    world = tiny_world(*TRAY, ball(8, "tray_1_1"), ball(9, "slot_1"))
    other, wanted = (parse_goal([text], world, WORDS) for text in ("Free(tray_1_1)", "Free(slot_1)"))
    found = find_causes(tiny_task(world, *other))

    repairs = find_repairs(found, world, wanted, able(world), trial(world, planners))

    assert [repair.text for repair in repairs] == [
        "put ball_9 in box_a",
        "remove ball_9 from the scene",
    ]
