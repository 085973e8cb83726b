"""A skill uses the devices of the robot that does it, whoever chooses them."""

from __future__ import annotations

from dataclasses import replace

import pytest

from skiros_py.planning.plan import Plan
from skiros_py.skills.outcome import Failure, Success
from skiros_py.skills.parameters import Kind, Param
from skiros_py.skills.skill import SkillDescription
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import HAS_PART, HOLDING, IN_CONTAINER, PICK, PLACE, pretend

_GRIPPER = Param("Gripper", "sk:Gripper", "The hand.", Kind.HARDWARE)
SQUEEZE = SkillDescription(
    name="squeeze",
    help="Squeezes a ball.",
    agent="Arm",
    target="Ball",
    params=(
        Param("Arm", "sk:Arm", "The arm.", Kind.HARDWARE),
        _GRIPPER,
        Param("Ball", "tiny:Ball", "The ball."),
        Param("Box", "tiny:Box", "Where it lies."),
    ),
    pre=(IN_CONTAINER("Ball", "Box"),),
    post=(HOLDING("Gripper", "Ball"),),
)
"""Nothing in it says that arm and gripper have to do with each other."""

TWO_ARMS = """
    scene:robot_1 sk:hasA scene:arm_0 .
    scene:arm_0 a sk:Arm ; rdfs:label "arm 0" ; sk:joints "s e" ; sk:tip "tip" ; sk:home "0 0"^^sk:vectorLiteral ;
        sk:hasA scene:gripper_0 .
    scene:gripper_0 a sk:Gripper ; rdfs:label "gripper 0" ; sk:joints "f" ; sk:maxGap 0.1 ; sk:maxForce 10.0 .
"""


@pytest.fixture
def bench() -> Bench:
    return Bench(tiny_world(robots=2), (pretend(SQUEEZE),))


@pytest.mark.parametrize("number", [1, 2])
def test_an_omitted_device_is_inferred_from_the_executing_robot(bench: Bench, number: int) -> None:
    with bench:
        panel = bench.managers[f"arm_{number}"].panel("squeeze", {})
        outcome = bench.run("squeeze", Arm=f"arm_{number}", Ball="ball_1")

        assert isinstance(outcome, Success)
        assert bench.world.objects("ball_1", "sk:heldBy") == (f"gripper_{number}",)
        assert panel.values["Gripper"] == f"gripper_{number}"


def test_a_device_of_another_robot_is_refused(bench: Bench) -> None:
    with bench:
        outcome = bench.run("squeeze", Arm="arm_2", Gripper="gripper_1", Ball="ball_1")

    assert isinstance(outcome, Failure)
    assert outcome.reason == "precondition OfOneRobot(arm_2, gripper_1): gripper_1 is no piece of robot_2"


@pytest.mark.parametrize("number", [1, 2])
def test_plans_use_each_robot_with_its_own_devices(bench: Bench, number: int) -> None:
    with bench:
        outcome = bench.plan(f"Holding(gripper_{number}, ball_1)").outcome

    assert isinstance(outcome, Plan)
    assert [step.arguments["Arm"] for step in outcome.steps] == [f"arm_{number}"]


@pytest.mark.parametrize("number", [0, 1])
def test_of_a_robot_with_two_arms_each_uses_its_own_device(number: int) -> None:
    with Bench(tiny_world(TWO_ARMS), (pretend(SQUEEZE),)) as bench:
        panel = bench.managers[f"arm_{number}"].panel("squeeze", {"Ball": "ball_1"})

    assert panel.values["Gripper"] == f"gripper_{number}"
    assert panel.reasons["Gripper"] == f"of 2 that fit, preferred: gripper_{number} is a piece of arm_{number}"


def test_preferences_of_the_author_take_precedence_over_distance() -> None:
    choosy = replace(_GRIPPER, cost=lambda _view, gripper: float(gripper != "gripper_1"))
    skill = replace(SQUEEZE, params=(SQUEEZE.params[0], choosy, *SQUEEZE.params[2:]))

    with Bench(tiny_world(TWO_ARMS), (pretend(skill),)) as bench:
        assert bench.managers["arm_0"].panel("squeeze", {"Ball": "ball_1"}).values["Gripper"] == "gripper_1"


@pytest.mark.parametrize(
    ("skill", "added"),
    [
        (PICK, 0),
        (PLACE, 0),
        (SQUEEZE, 1),
        (replace(SQUEEZE, pre=(HAS_PART("Arm", "Gripper"),)), 0),
        (replace(SQUEEZE, params=(SQUEEZE.params[0], replace(_GRIPPER, kind=Kind.ONLINE), *SQUEEZE.params[2:])), 0),
    ],
)
def test_structural_preconditions_that_are_already_declared_are_not_added_again(
    skill: SkillDescription, added: int
) -> None:
    assert len(skill.needs) == len(skill.pre) + added
