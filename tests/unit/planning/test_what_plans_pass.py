"""Plans speak of the parameters that conditions speak of; the others are left to defaults and to inference."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import pytest
from support.planning import tiny_task

from skiros_py.planning.plan import NoPlan, Plan
from skiros_py.skills.conditions import Condition, Related
from skiros_py.skills.parameters import IT, Kind, Param
from skiros_py.skills.skill import SkillDescription
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, FREE, HOLDING, IN_CONTAINER, PICK, REACHABLE, SKILLS, pretend
from skiros_py.world.vocabulary import IN, ON
from skiros_py.world.world import World

HELD = "Holding(gripper_1, ball_1)"
KEYS = {"Arm", "Gripper", "Robot", "Box", "Ball"}


def pick_with(param: Param, pre: Sequence[Condition] = (), post: Sequence[Condition] = ()) -> SkillDescription:
    return replace(PICK, params=(*PICK.params, param), pre=(*PICK.pre, *pre), post=(*PICK.post, *post))


def plan(skill: SkillDescription, goal: str = HELD, world: World | None = None) -> Plan | NoPlan:
    with Bench(world or tiny_world(), (pretend(DRIVE), pretend(skill))) as bench:
        return bench.plan(goal).outcome


def passed(outcome: Plan | NoPlan) -> Mapping[str, str]:
    assert isinstance(outcome, Plan), outcome
    assert outcome.groundings, "it is a plan of the task as well"
    return outcome.steps[-1].arguments


@pytest.mark.parametrize("class_", ["tiny:Slot", "tiny:Giant"])
def test_a_plan_leaves_an_optional_element_open(class_: str) -> None:
    helper = Param("Helper", class_, "One that helps.", Kind.OPTIONAL)
    spoken = (IN_CONTAINER("Ball", "Helper"),) if class_ == "tiny:Slot" else ()

    assert passed(plan(pick_with(helper))).keys() == KEYS
    assert passed(plan(pick_with(helper, pre=spoken, post=spoken))).keys() == KEYS


@pytest.mark.parametrize(("slot", "is_plan"), [("slot_2", True), ("slot_1", False)])
def test_conditions_on_a_parameter_with_a_default_use_the_default(slot: str, is_plan: bool) -> None:
    spare = Param("Spare", "tiny:Slot", "A slot that must be free.", Kind.OFFLINE, default=slot)
    world = tiny_world("scene:ball_9 a tiny:Ball ; sk:in scene:slot_1 .")

    outcome = plan(pick_with(spare, pre=(FREE("Spare"),)), world=world)

    assert isinstance(outcome, Plan) is is_plan
    if is_plan:
        assert passed(outcome).keys() == KEYS
    else:
        assert isinstance(outcome, NoPlan)
        assert "needs that nothing is in slot_1, and ball_9 is in slot_1" in outcome.reasons[0]


def test_effects_on_a_default_reach_goals_and_are_written() -> None:
    tray = Param("Tray", "tiny:Slot", "Where it is put at last.", Kind.OFFLINE, default="slot_2")
    tidy = replace(pick_with(tray, pre=(FREE("Tray"),)), post=(IN_CONTAINER("Ball", "Tray"),))

    with Bench(tiny_world(), (pretend(DRIVE), pretend(tidy))) as bench:
        report = bench.pursue("In(ball_1, slot_2)")
        outcome = bench.plan("In(ball_1, slot_1)").outcome

    assert report.conditions[0].believed
    assert isinstance(outcome, NoPlan)


def test_a_skill_whose_default_element_was_removed_is_not_planned() -> None:
    spare = Param("Spare", "tiny:Slot", "A slot that must be free.", Kind.OFFLINE, default="slot_9")

    assert isinstance(plan(pick_with(spare, pre=(FREE("Spare"),))), NoPlan)


@pytest.mark.parametrize(
    "param",
    [
        Param("Tool", "tiny:Slot", "By cost.", cost=lambda _view, slot: float(slot == "slot_1")),
        Param("Tool", "tiny:Slot", "By preference.", prefer=Related(ON, IT, "Box")),
    ],
    ids=["cost", "prefer"],
)
def test_parameters_without_conditions_are_chosen_at_the_start_by_preference(param: Param) -> None:
    world = tiny_world("scene:slot_3 a tiny:Slot ; sk:on scene:box_a .") if param.preferred else tiny_world()

    with Bench(world, (pretend(DRIVE), pretend(pick_with(param)))) as bench:
        steps = bench.plan(HELD).outcome
        bench.pursue(HELD)
        told = next(e.text for e in bench.events if e.module == "pick" and e.status.value == "started")

    assert passed(steps).keys() == KEYS
    assert f"Tool={'slot_3' if param.preferred else 'slot_2'}" in told


def test_a_plan_passes_a_parameter_with_a_description() -> None:
    full = Param("Other", "tiny:Box", "A box with something in it.", where=Related(IN, "Ball", IT))

    assert passed(plan(pick_with(full)))["Other"] == "box_a"


def test_a_missing_required_element_makes_planning_impossible() -> None:
    outcome = plan(pick_with(Param("Tool", "tiny:Giant", "Any giant.")))

    assert isinstance(outcome, NoPlan)
    assert "there is no Giant" in outcome.reasons[0]


# ---------------------------------------------------------------------- what implementations ask for


def ways(*whens: tuple[Condition, ...]) -> SkillDescription:
    return DRIVE.under(whens)


def test_a_skill_with_one_implementation_is_planned_with_the_condition_of_that_implementation() -> None:
    never = pretend(DRIVE)
    never = replace(never, when=(AT_LOCATION("Robot", "Location"),))

    with Bench(tiny_world(), (never,)) as bench:
        outcome = bench.plan("At(robot_1, box_a)").outcome
        report = bench.pursue("At(robot_1, box_a)")

    assert isinstance(outcome, NoPlan)
    (reason,) = outcome.reasons
    assert reason == (
        "At(robot_1, box_a) cannot be reached: skill 'drive' would do it, but needs that robot_1 is at box_a, "
        "and robot_1 is at unknown_location, and no skill takes it from there"
    )
    assert not report.steps


def test_other_skills_establish_the_condition_of_an_implementation() -> None:
    full = replace(pretend(DRIVE), label="full", when=(~FREE("Location"),))
    params = tuple(replace(p, type="tiny:Slot") if p.key == "Location" else p for p in DRIVE.params)
    to_slot = replace(DRIVE, name="visit", params=params, pre=DRIVE.pre[:1])
    visit = replace(full, description=to_slot)

    with Bench(tiny_world(), (*SKILLS, visit)) as bench:
        outcome = bench.plan("At(robot_1, slot_1)").outcome

    assert isinstance(outcome, Plan)
    assert [step.skill for step in outcome.steps] == ["drive", "pick", "place", "visit"]


def test_an_implementation_without_a_condition_is_sufficient() -> None:
    assert ways((), (FREE("Location"),)) is DRIVE
    assert ways() is DRIVE


def test_any_implementation_is_sufficient() -> None:
    both = (REACHABLE("Location"), AT_LOCATION("Robot", "Location"))
    either = ways((FREE("Location"),), both, both)

    assert [str(c) for c in either.pre[len(DRIVE.pre) :]] == [
        "Free(Location) or (Reachable(Location) and At(Robot, Location))"
    ]
    names = [
        action.name
        for action in tiny_task(tiny_world(), HOLDING("gripper_1", "ball_1"), skills=(either,)).domain.actions
    ]
    assert names
