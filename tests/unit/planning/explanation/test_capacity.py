"""How much there is room for, also inside composite goals: what is said to be impossible certainly is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from random import Random

import pytest
from mutations import IN_TRAY
from support.planning import tiny_task

from skiros_py.planning.explanation.causes import find_causes
from skiros_py.planning.explanation.trial import Trial
from skiros_py.planning.plan import Cause, CauseKind
from skiros_py.planning.planners.kairos import Kairos
from skiros_py.planning.planners.planner import Planners
from skiros_py.planning.problem.task import Capability
from skiros_py.skills.conditions import ConditionType, Nothing, Role
from skiros_py.skills.skill import SkillDescription
from skiros_py.tasks.goals import parse_goal
from skiros_py.testing import CONDITIONS, tiny_world
from skiros_py.testing.tiny import DRIVE, PICK, PLACE
from skiros_py.world.vocabulary import AT
from skiros_py.world.world import World

WORDS = {**CONDITIONS, "InTray": IN_TRAY}
UNOCCUPIED = ConditionType("Unoccupied", (Role("location", "sk:Location"),), Nothing(AT, "location"), "No robot there.")
ALONE = replace(DRIVE, pre=(*DRIVE.pre, UNOCCUPIED("Location")))


@pytest.fixture(scope="module")
def planners() -> Iterator[Planners]:
    found = Planners.only(Kairos())
    yield found
    found.close()


def tray(slots: int, *facts: str, robots: int = 1) -> World:
    """A tray of so many slots, and two balls besides what is said."""
    names = [f"scene:tray_1_{n}" for n in range(1, slots + 1)]
    own = [f"{name} a tiny:Slot ." for name in names]
    whole = f"scene:tray_1 a sk:Container ; sk:on scene:floor ; sk:hasA {' , '.join(names)} ."
    return tiny_world(whole, *own, *facts, robots=robots)


def causes(world: World, *goal: str, skills: tuple[SkillDescription, ...] = (DRIVE, PICK, PLACE)) -> tuple[Cause, ...]:
    task = tiny_task(world, *parse_goal(list(goal), world, WORDS), skills=skills)
    return tuple(found.cause for found in find_causes(task))


@pytest.mark.parametrize(
    "goal",
    [
        "for all b: Ball (InTray(b, tray_1))",
        "for all b: Ball (InTray(b, tray_1) or In(b, tray_1_1))",
        "for all b: Ball (exists t: Container (In(b, t) and HasPart(tray_1, t)))",
    ],
)
def test_a_goal_for_all_needs_room_for_each_element(goal: str) -> None:
    (cause,) = causes(tray(1), goal)

    assert cause.kind is CauseKind.FULL
    assert "room for 1 only (tray_1_1), and 2 are wanted there (ball_1 and red_ball_1)" in cause.text
    assert causes(tray(2), goal) == ()


def test_a_goal_that_needs_more_things_than_exist_is_explained_by_their_number() -> None:
    (cause,) = causes(tray(2), "for all s: Slot (exists b: RedBall (In(b, s)))")

    assert cause.kind is CauseKind.TOO_FEW
    assert "4 of RedBall are wanted, but there is only red_ball_1" in cause.text


@pytest.mark.parametrize(
    ("goal", "why"),
    [
        (
            "exists b: RedBall (Holding(gripper_1, b) and In(b, tray_1_1))",
            "a RedBall has one place only, it cannot be held by gripper_1 and in tray_1_1",
        ),
        (
            "exists b: Ball (Holding(gripper_1, b) and InTray(b, tray_1))",
            "a Ball has one place only, it cannot be held by gripper_1 and in tray_1_1 or tray_1_2",
        ),
        (
            "exists b: RedBall (exists c: RedBall (In(b, slot_1) and In(c, slot_2)))",
            "2 of RedBall are wanted, but there is only red_ball_1",
        ),
    ],
)
def test_one_thing_wanted_in_two_places_is_not_counted_as_two_things(goal: str, why: str) -> None:
    (cause,) = causes(tray(2), goal)

    assert cause.text == f"{goal} cannot be reached: {why}"


@pytest.mark.parametrize(
    "goal",
    [
        "for all s: Slot (In(RedBall, s))",
        "exists b: RedBall (exists c: RedBall (In(b, slot_1) and In(c, slot_2)))",
        "exists b: RedBall (In(b, slot_1) and (exists c: RedBall (Holding(gripper_1, c))))",
        "exists b: RedBall (In(b, slot_1) and (In(RedBall, slot_2) or In(b, slot_2)))",
        "exists b: RedBall (In(b, slot_1) and In(b, slot_2) and In(RedBall, tray_1_1))",
    ],
)
def test_things_that_are_too_few_are_no_longer_too_few_once_those_missing_are_there(goal: str) -> None:
    few = [cause for cause in causes(tray(1), goal) if cause.kind is CauseKind.TOO_FEW]
    missing = [int(cause.why.partition(" ")[0]) - 1 for cause in few]
    more = [f"scene:red_{n} a tiny:RedBall ; sk:in scene:box_a ." for n in range(sum(missing))]

    assert CauseKind.TOO_FEW not in [cause.kind for cause in causes(tray(1, *more), goal)]


def test_a_relation_that_should_end_and_cannot_is_explained_by_what_holds() -> None:
    (cause,) = causes(tray(1), "not HasPart(robot_1, arm_1)")

    assert cause.text == "not HasPart(robot_1, arm_1) cannot be reached: robot_1 has arm_1, and no skill changes it"


def test_a_place_that_already_holds_two_things_is_not_explained_as_full() -> None:
    crowded = [f"scene:{ball} sk:in scene:tray_1_1 ." for ball in ("ball_8", "ball_9")]
    world = tray(1, *(f"scene:{ball} a tiny:Ball ." for ball in ("ball_8", "ball_9")), *crowded)

    assert causes(world, "In(ball_8, tray_1_1)", "In(ball_9, tray_1_1)") == ()


def test_a_place_that_robots_need_empty_has_room_for_one_robot() -> None:
    skills = ALONE, PICK, PLACE

    (cause,) = causes(tray(1, robots=2), "At(robot_1, box_a)", "At(robot_2, box_a)", skills=skills)

    assert cause.kind is CauseKind.CONTRADICTION
    assert cause.text.endswith("box_a takes one robot only")


@pytest.mark.parametrize("seed", range(12))
def test_a_goal_with_a_proven_cause_has_no_plan(seed: int, planners: Planners) -> None:
    random = Random(seed)
    world = tray(random.randint(1, 2), *drawn_balls(random))
    goal = parse_goal([drawn(random, 2) for _ in range(random.randint(1, 2))], world, WORDS)
    skills = [Capability(skill, world.instances(skill.agent_class)) for skill in (DRIVE, PICK, PLACE)]

    found = find_causes(tiny_task(world, *goal))

    assert not found or Trial(planners, skills, each=30.0, together=30.0)(world, goal) is not True, found


def drawn_balls(random: Random) -> list[str]:
    places = ("box_a", "box_b", "slot_1", "slot_2", "tray_1_1")
    return [
        f"scene:ball_{n} a tiny:Ball ; sk:in scene:{random.choice(places)} ." for n in range(2, random.randint(2, 4))
    ]


def drawn(random: Random, depth: int) -> str:
    """Draws a condition; inside of a quantifier mostly about what it ranges over."""
    kind = random.choice(("plain", "plain", "and", "or", "not", "for all", "exists") if depth else ("plain",))
    if kind == "plain":
        return drawn_plain(random, random.choice(("Ball", "RedBall", "ball_1", "red_ball_1")))
    if kind in ("and", "or"):
        return f"({drawn(random, depth - 1)} {kind} {drawn(random, depth - 1)})"
    if kind == "not":
        return f"not ({drawn(random, depth - 1)})"
    joint = random.choice(("", f" and {drawn(random, 0)}", f" or {drawn_plain(random, 'b')}"))
    return f"({kind} b: {random.choice(('Ball', 'RedBall'))} ({drawn_plain(random, 'b')}{joint}))"


def drawn_plain(random: Random, ball: str) -> str:
    place = random.choice(("slot_1", "slot_2", "tray_1_1", "box_a"))
    return random.choice((f"In({ball}, {place})", f"InTray({ball}, tray_1)", f"not In({ball}, {place})"))
