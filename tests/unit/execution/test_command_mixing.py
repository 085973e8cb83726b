"""Mix: runs that share a device are merged by the rule of its kind; a rule that breaks hurts only those runs."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import pytest

from skiros_py.behaviours import Do, P, Parallel
from skiros_py.devices.gripper import Gripper, GripperTarget
from skiros_py.devices.mobile_base import Base, BaseSpec, BaseTwist
from skiros_py.ports.device import Contribution
from skiros_py.skills.outcome import Failure, Outcome
from skiros_py.skills.parameters import Access, Kind, Param, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill, SkillDescription
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import AT_LOCATION
from skiros_py.world.vocabulary import AT


class Push(Primitive["Push.Params"]):
    """Drives at a constant speed and lets others drive, too."""

    name: ClassVar[str] = "push"

    @dataclass(frozen=True, slots=True)
    class Params:
        base: str = param("sk:Base", "The base.", kind=Kind.HARDWARE, access=Access.SHARED)
        linear: float = param("number", "Speed.", default=0.0, unit="m/s")
        angular: float = param("number", "Turning speed.", default=0.0, unit="rad/s")
        weight: float = param("number", "Weight among others.", default=1.0)

    def execute(self) -> Execution[Outcome]:
        given = self.params
        while True:
            Base(self.context.board, given.base).command(BaseTwist(given.linear, given.angular), given.weight)
            yield


class Turn(Push):
    """The same under another name, so that both can be started by themselves."""

    name: ClassVar[str] = "turn"


class Squeeze(Primitive["Squeeze.Params"]):
    """Shares a gripper, whose kind has no mix rule."""

    name: ClassVar[str] = "squeeze"

    @dataclass(frozen=True, slots=True)
    class Params:
        gripper: str = param("sk:Gripper", "The gripper.", kind=Kind.HARDWARE, access=Access.SHARED)

    def execute(self) -> Execution[Outcome]:
        while True:
            Gripper(self.context.board, self.params.gripper).command(GripperTarget(0.0, 10.0))
            yield


DANCE = Skill(
    SkillDescription(
        "dance",
        "Drives in two ways at once.",
        agent="Base",
        target="Place",
        params=(
            Param("Base", "sk:Base", "The base.", Kind.HARDWARE),
            Param("Robot", "sk:Robot", "Its robot.", Kind.PLANNING),
            Param("Place", "sk:Location", "Where it is."),
        ),
        post=(AT_LOCATION("Robot", "Place"),),
    ),
    Parallel.of(Do.of("push", base=P("Base"), linear=0.2), Do.of("push", base=P("Base"), angular=0.4, weight=3.0)),
    driver="fake",
)


def bench_of(*skills: Skill, **options: Any) -> Bench:
    return Bench(tiny_world(), skills, [Push, Turn, Squeeze], **options)


def speeds(bench: Bench) -> tuple[float, float]:
    state = bench.cycle.board.snapshot.devices["base_1"]
    return state.linear, state.angular


def raises(_self: BaseSpec, _contributions: Sequence[Contribution[BaseTwist]]) -> BaseTwist:
    raise ZeroDivisionError("no such luck")


def not_a_number(_self: BaseSpec, _contributions: Sequence[Contribution[BaseTwist]]) -> BaseTwist:
    return BaseTwist(math.nan, 0.0)


def hangs(_self: BaseSpec, _contributions: Sequence[Contribution[BaseTwist]]) -> BaseTwist:
    while True:
        time.sleep(0.001)


def test_two_branches_of_one_task_that_share_a_device_are_merged_by_weight() -> None:
    with bench_of(DANCE) as bench:
        bench.start("dance", Base="base_1", Place=bench.world.objects("robot_1", AT)[0])
        bench.advance(0.05)

        assert speeds(bench) == pytest.approx((0.05, 0.3))


def test_commands_of_two_tasks_are_merged_until_one_task_remains() -> None:
    with bench_of() as bench:
        push, _ = bench.start("push", base="base_1", linear=0.2), bench.start("turn", base="base_1", angular=0.4)
        bench.advance(0.05)
        assert speeds(bench) == pytest.approx((0.1, 0.2))

        push.stop()
        bench.advance(0.05)
        assert speeds(bench) == pytest.approx((0.0, 0.4))
        assert push.done


def test_commands_of_a_sole_sharer_are_not_mixed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(BaseSpec, "mixed", raises)
    with bench_of() as bench:
        bench.start("push", base="base_1", linear=0.2)
        bench.advance(0.05)

        assert speeds(bench) == (0.2, 0.0)


@pytest.mark.parametrize("rule", [raises, not_a_number])
def test_a_mix_rule_that_raises_brakes_the_device_and_fails_its_runs_and_the_cycle_continues(
    monkeypatch: pytest.MonkeyPatch, rule: Any
) -> None:
    monkeypatch.setattr(BaseSpec, "mixed", rule)
    with bench_of() as bench:
        one, other = bench.start("push", base="base_1", linear=0.2), bench.start("turn", base="base_1", angular=0.4)
        bench.advance(0.05)

        assert speeds(bench) == (0.0, 0.0)
        for run in (one, other):
            assert isinstance(run.result, Failure)
            assert "the mix rule of kind 'base' was switched off in cycle" in run.result.reason
        assert not bench.cycle.halted

        monkeypatch.undo()
        bench.cycle.reset()
        bench.start("push", base="base_1", linear=0.2)
        bench.start("turn", base="base_1", angular=0.4)
        bench.advance(0.05)
        assert speeds(bench) == pytest.approx((0.1, 0.2))


def test_a_mix_rule_that_hangs_is_interrupted_and_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(BaseSpec, "mixed", hangs)
    with bench_of(overrun=0.2) as bench:
        bench.start("push", base="base_1", linear=0.2)
        bench.start("turn", base="base_1", angular=0.4)
        for _ in range(5):
            bench.cycle.step()

        assert "the mix rule of kind 'base' held the control cycle" in bench.cycle.halted
        assert "held the control cycle" in bench.cycle.board.unmixed["base"]
        assert speeds(bench) == (0.0, 0.0)


def test_a_weight_that_is_not_positive_is_refused() -> None:
    with bench_of() as bench:
        run = bench.start("push", base="base_1", linear=0.2, weight=0.0)
        bench.advance(0.05)

        assert isinstance(run.result, Failure)
        assert "weight of a command is a positive number, not 0.0" in run.result.reason


def test_sharing_a_device_whose_kind_has_no_mix_rule_is_refused_by_name() -> None:
    with bench_of() as bench:
        run = bench.start("squeeze", gripper="gripper_1")
        bench.advance(0.05)

        assert isinstance(run.result, Failure)
        assert "squeeze shares gripper_1, but kind 'gripper' has no mix rule" in run.result.reason
