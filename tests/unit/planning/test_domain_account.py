"""What an author is told of a domain: what was added to the skills, and why."""

from __future__ import annotations

from dataclasses import asdict, replace

from support.planning import tiny_pddl

from skiros_py.planning.domain.model import SkillAccount, account_of
from skiros_py.skills.conditions import Condition, ConditionType, Exists, Nothing, Related, Role, any_of
from skiros_py.skills.skill import SkillDescription
from skiros_py.testing import tiny_world
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, HOLDING, IN_CONTAINER, PICK, PLACE
from skiros_py.world.world import World

_TINY = (DRIVE, PICK, PLACE)


def told(
    *goal: Condition, skills: tuple[SkillDescription, ...] = _TINY, world: World | None = None
) -> dict[str, SkillAccount]:
    texts = tiny_pddl(world or tiny_world(), *goal, skills=skills)
    return {account.skill: account for account in account_of(skills, list(texts.actions.items()))}


def notes(account: SkillAccount) -> str:
    return "\n".join(note for action in account.actions for note in action.notes)


def test_the_declared_conditions_come_first_in_the_account() -> None:
    drive = told(AT_LOCATION("robot_1", "box_a"))["drive"]

    assert drive.pre == ("HasPart(Robot, Base)", "Reachable(Location)")
    assert drive.post == ("At(Robot, Location)",)


def test_the_account_of_driving_explains_the_capability_and_the_left_place() -> None:
    drive = notes(told(AT_LOCATION("robot_1", "box_a"))["drive"])

    assert "precondition can_drive(Base): who has the skill" in drive
    assert "parameter Robot_from, precondition at(Robot, Robot_from): the place that Robot leaves" in drive
    assert "effect not at(Robot, Robot_from): Robot has one place only" in drive


def test_the_account_explains_how_places_become_full_and_empty() -> None:
    account = told(IN_CONTAINER("ball_1", "slot_1"))

    assert "effect not nothing heldBy(Gripper): something is there now" in notes(account["pick"])
    assert "effect nothing heldBy(Gripper): it held one thing only" in notes(account["place"])


def test_the_account_explains_where_negated_facts_change() -> None:
    account = told(~IN_CONTAINER("ball_1", "box_a"))

    assert "effect not in(Ball, Box): others ask that something is not so" in notes(account["pick"])


def test_a_skill_that_the_goal_cannot_need_has_no_action() -> None:
    texts = tiny_pddl(tiny_world(), AT_LOCATION("robot_1", "box_a"), skills=(DRIVE,))

    drive, pick = account_of((DRIVE, PICK), list(texts.actions.items()))

    assert drive.actions
    assert pick.actions == ()


def test_each_variant_names_the_alternative_it_stands_for() -> None:
    either = any_of(HOLDING("Gripper", "Ball"), IN_CONTAINER("Ball", "Box"))
    again = replace(PICK, pre=(*(c for c in PICK.pre if c.type is not IN_CONTAINER), either))
    world = tiny_world("scene:ball_8 a tiny:Ball ; sk:heldBy scene:gripper_1 .")
    pick = told(HOLDING("gripper_1", "ball_1"), skills=(DRIVE, again, PLACE), world=world)["pick"]

    assert [action.name for action in pick.actions] == ["pick_1", "pick_2"]
    assert "variant: way 1 of" in pick.actions[0].notes[1]
    assert "variant: way 2 of" in pick.actions[1].notes[1]


def test_the_account_explains_class_predicates() -> None:
    bench = "scene:bench_1 a tiny:Bench ; sk:on scene:floor . scene:ball_5 a tiny:Ball ; sk:in scene:bench_1 ."
    account = told(IN_CONTAINER("ball_5", "slot_1"), world=tiny_world(bench))

    assert "class tiny:Box is asked for by a predicate, some have it by a second parent" in notes(account["pick"])


def test_the_bookkeeping_of_a_goal_comes_last_with_its_purpose() -> None:
    account = told(IN_CONTAINER("tiny:Ball", "slot_1"))

    assert list(account)[-1] == ""
    assert "goal 'In(Ball, slot_1)': one action for each way in which this part of it can hold" in notes(account[""])
    assert "precondition working: all is done before the goal is looked for" in notes(account["drive"])


def test_the_account_explains_a_quantifier_used_instead_of_bookkeeping() -> None:
    careless = replace(PLACE, name="throw", pre=tuple(c for c in PLACE.pre if not isinstance(c.pattern, Nothing)))
    account = told(IN_CONTAINER("ball_1", "slot_1"), skills=(*_TINY, careless))

    assert "precondition nothing in(Slot) with a quantifier: not every skill keeps track of it" in notes(
        account["place"]
    )


def test_the_account_is_available_as_plain_data() -> None:
    data = asdict(told(AT_LOCATION("robot_1", "box_a"))["drive"])

    assert data["skill"] == "drive"
    assert data["actions"][0]["name"] == "drive"
    assert data["actions"][0]["parameters"][0] == "Base: sk:Base"


def test_a_goal_of_facts_needs_no_bookkeeping() -> None:
    assert "" not in told(AT_LOCATION("robot_1", "box_a"))


def test_a_variable_of_a_goal_is_typed() -> None:
    word = ConditionType(
        "Kept", (Role("ball_1", "tiny:Ball"),), Exists("s", "tiny:Slot", Related("sk:in", "ball_1", "s")), "-"
    )

    reach = told(word("ball_1"))[""].actions[-1]
    assert reach.parameters == ("s #1: tiny:Slot",)
