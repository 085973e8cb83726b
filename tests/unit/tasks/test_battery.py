"""A robot with a battery on the fake cell: it charges by itself when it has to, and believes what was sensed."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import pytest
from support.battery import CHARGE, at_least, battery_world, charging, driving

from skiros_py.behaviours import AssertEffects, Behaviour, Do, P, Sequence
from skiros_py.planning.planners.kairos import Kairos
from skiros_py.skills.outcome import Execution, Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Primitive
from skiros_py.testing.bench import Bench
from skiros_py.testing.tiny import PICK, PLACE, pretend

GOALS = ("In(ball_1, slot_1)", "In(red_ball_1, slot_2)")


class ReadBattery(Primitive["ReadBattery.Params"]):
    """Reads a battery that has lost more than expected, and asserts what the skill says of it."""

    name: ClassVar[str] = "read_battery"

    @dataclass(frozen=True, slots=True)
    class Params:
        robot: str = param("sk:Robot", "Whose battery.", kind=Kind.PLANNING)
        reading: float = param("number", "What it says.", kind=Kind.OFFLINE, default=8.47)
        effect: str = param("text", "The postcondition.", kind=Kind.OFFLINE, default="charge")
        says: bool = param("boolean", "Whether it tells the value.", kind=Kind.OFFLINE, default=True)

    def execute(self) -> Execution[Outcome]:
        yield
        sensed = self.params.reading if self.params.says else None
        self.assert_effects(self.params.effect, reason="the battery says so", sensed=sensed)
        return Success("read")


def benched(charge: float, drive_body: Behaviour | None = None) -> Bench:
    drive = driving()
    named = replace(drive, post=(drive.post[0].named("there"), drive.post[1].named("charge")))
    body = AssertEffects(0.02) if drive_body is None else drive_body
    skills = (pretend(named, body), pretend(PICK), pretend(PLACE), pretend(charging()))
    return Bench(battery_world(charge), skills, (ReadBattery,), planner=Kairos())


@pytest.mark.parametrize(("charge", "left", "times"), [(60.0, 10.0, 0), (30.0, 10.0, 1), (100.0, 50.0, 0)])
def test_a_robot_charges_by_itself_only_when_it_has_to(charge: float, left: float, times: int) -> None:
    with benched(charge) as bench:
        report = bench.pursue(*GOALS)

        assert report.reached, report
        assert bench.world.value("robot_1", CHARGE) == left
        assert [step.skill for step in report.steps].count("recharge") == times


def test_a_charge_that_falls_faster_than_expected_is_believed_and_ends_the_plan_with_it_as_the_reason() -> None:
    body = Sequence.of(AssertEffects(0.02, ("there",)), Do.of("read_battery", robot=P("Robot"), reading=24.0))
    with benched(60.0, body) as bench:
        report = bench.pursue(*GOALS)

        assert not report.reached
        assert [step.skill for step in report.steps].count("drive") == 1
        assert bench.world.value("robot_1", CHARGE) == 24.0
        assert any("the charge of robot_1 is 24, not at least 25" in c.reason for c in report.conditions), report


def charge_read(reading: float, *, says: bool = True) -> tuple[Outcome, object]:
    body = Do.of("read_battery", robot=P("Robot"), reading=reading, says=says)
    named = replace(charging(None, None), post=(at_least(8)("Robot").named("charge"),))
    with Bench(battery_world(1.5), (pretend(named, body),), (ReadBattery,)) as bench:
        return bench.run("recharge", Socket="socket_1"), bench.world.value("robot_1", CHARGE)


def test_a_sensed_number_that_meets_an_inequality_is_what_the_world_holds_afterwards() -> None:
    outcome, value = charge_read(8.47)

    assert isinstance(outcome, Success), outcome
    assert value == 8.47


def test_a_sensed_number_that_misses_an_inequality_is_believed_and_fails_the_skill() -> None:
    outcome, value = charge_read(6.2)

    assert isinstance(outcome, Failure)
    assert "the charge of robot_1 is 6.2, not at least 8" in outcome.reason
    assert value == 6.2


def test_a_primitive_cannot_assert_an_open_number_without_saying_what_it_sensed() -> None:
    outcome, value = charge_read(8.47, says=False)

    assert isinstance(outcome, Failure)
    assert "the charge of robot_1 is not said by the postcondition: assert it with sensed=…" in outcome.reason
    assert value == 1.5
