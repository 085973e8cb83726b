"""Modules call modules: over subsystems, out of the caller's devices, and with an end for everything called."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import pytest

from skiros_py.behaviours import AssertEffects, Behaviour, Do, Fallback, P, Parallel, Sequence, Wait
from skiros_py.devices.gripper import Gripper, GripperTarget
from skiros_py.devices.mobile_base import Base, BaseTwist
from skiros_py.errors import DescriptionError
from skiros_py.execution.monitor import Status
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import Failure, Outcome, Success, tick
from skiros_py.skills.parameters import Kind, Param, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import AT_LOCATION, DRIVE, PICK, pretend

BASE = Param("Base", "sk:Base", "The base that comes along.", Kind.HARDWARE)
FETCH = replace(PICK, name="fetch", params=(*PICK.params, BASE), pre=())
GO_AND_PICK = Sequence.of(Do.of("drive", Base=P("Base"), Location=P("Box")), AssertEffects(0.0))
TO_BALL = {"Ball": "ball_1", "Box": "box_a"}


@dataclass(frozen=True, slots=True)
class WithGripper:
    gripper: str = param("sk:Gripper", "The gripper.", kind=Kind.HARDWARE)


class Grip(Primitive[WithGripper]):
    """Holds the gripper until it is cancelled, then takes three cycles to let go."""

    name: ClassVar[str] = "grip"
    Params = WithGripper
    log: ClassVar[list[str]] = []

    def execute(self) -> Execution[Outcome]:
        while True:
            yield

    def recover(self) -> Execution[None]:
        for _ in range(3):
            self.log.append("lets go")
            yield


class Tap(Grip):
    """Closes the gripper once."""

    name: ClassVar[str] = "tap"

    def execute(self) -> Execution[Outcome]:
        self.log.append("taps")
        Gripper(self.context.board, self.params.gripper).command(GripperTarget(0.01, 10.0))
        yield
        return Success()


@pytest.fixture(autouse=True)
def _fresh() -> None:
    Grip.log.clear()


def primitive(name_: str, execute_: Callable[[Any], Execution[Outcome]], params: type[Any] = WithGripper) -> type[Any]:
    """Makes a primitive out of a function."""
    members = {"name": name_, "Params": params, "execute": execute_, "__doc__": f"{name_}."}
    return type(name_, (Primitive,), members)


# ------------------------------------------------------------------ skills of other subsystems


@pytest.mark.parametrize("number", [1, 2])
def test_a_skill_calls_a_skill_of_another_subsystem_of_its_own_robot(number: int) -> None:
    with Bench(tiny_world(robots=2), (pretend(DRIVE), pretend(FETCH, GO_AND_PICK))) as bench:
        robot = {"Arm": f"arm_{number}", "Gripper": f"gripper_{number}", "Base": f"base_{number}"}
        outcome = bench.run("fetch", **robot, **TO_BALL)

        assert outcome == Success("pretended")
        assert AT_LOCATION(f"robot_{number}", "box_a").evaluate(bench.world)
        assert {e.agent for e in bench.events if e.module == "drive"} == {f"base_{number}"}
        assert {e.caller for e in bench.events if e.module == "drive"} == {"fetch"}


def test_a_caller_must_claim_the_devices_that_a_called_skill_moves() -> None:
    lacking = replace(FETCH, params=PICK.params)
    body = Sequence.of(Do.of("drive", Location=P("Box")), AssertEffects(0.0))
    with Bench(tiny_world(), (pretend(DRIVE), pretend(lacking, body))) as bench:
        outcome = bench.run("fetch", **TO_BALL)

        assert isinstance(outcome, Failure)
        assert "drive needs base_1, but fetch has arm_1, gripper_1" in outcome.reason


def test_skills_of_a_removed_manager_are_no_longer_called() -> None:
    with Bench(tiny_world(), (pretend(DRIVE), pretend(FETCH, GO_AND_PICK))) as bench:
        bench.managers.close("base_1")
        outcome = bench.run("fetch", **TO_BALL)

        assert isinstance(outcome, Failure)
        assert "unknown module 'drive'" in outcome.reason


# ------------------------------------------------------------------ calls that are cancelled, or forgotten


def test_a_call_gets_the_devices_of_a_cancelled_parallel_call() -> None:
    def race(self: Any) -> Execution[Outcome]:
        held, waiting = (self.call(module, gripper=self.params.gripper) for module in ("grip", "tap"))
        tick(held), tick(waiting)
        yield
        held.close()
        return (yield from waiting)

    with Bench(tiny_world(), (), (Grip, Tap, primitive("race", race))) as bench:
        running = bench.start("race")
        bench.until(lambda: running.done, limit=1.0)

        assert running.result == Success()
        assert Grip.log == ["lets go"] * 3 + ["taps"]


def test_an_unclosed_call_ends_with_its_caller() -> None:
    def forgetful(self: Any) -> Execution[Outcome]:
        self.kept = self.call("grip", gripper=self.params.gripper)
        kept.append(self)
        tick(self.kept)
        yield
        return Success()

    kept: list[Any] = []
    with Bench(tiny_world(), (), (Grip, Tap, primitive("forgetful", forgetful))) as bench:
        assert bench.run("forgetful") == Success()
        assert Grip.log == ["lets go"] * 3
        assert [e.status for e in bench.events if e.module == "grip"] == [Status.STARTED, Status.PREEMPTED]
        assert bench.run("tap") == Success()


# ------------------------------------------------------------------ devices that were not taken


def test_a_primitive_in_a_skill_commands_only_devices_it_has_claimed_itself() -> None:
    def sly(self: Any) -> Execution[Outcome]:
        Base(self.context.board, "base_1").command(BaseTwist(0.1, 0.0))
        yield
        return Success()

    description = replace(DRIVE, params=(*DRIVE.params, Param("G", "sk:Gripper", "-", Kind.HARDWARE)))
    with Bench(tiny_world(), (pretend(description, Do.of("sly", gripper=P("G"))),), (primitive("sly", sly),)) as bench:
        outcome = bench.run("drive", Location="box_a")

        assert isinstance(outcome, Failure)
        assert "base_1 is not among the devices that were taken (gripper_1)" in outcome.reason


# ------------------------------------------------------------------ devices per attempt


def _ways(first: Behaviour, second: Behaviour, **more: Any) -> tuple[Skill, Skill]:
    return (
        Skill(AT_ONCE, first, driver="fake", label="first", order=1, **more),
        Skill(AT_ONCE, second, driver="fake", label="second", order=2),
    )


AT_ONCE = replace(DRIVE, pre=(), post=(AT_LOCATION("Robot", "Location"),))


def test_each_implementation_claims_only_its_own_devices() -> None:
    failing = Sequence.of(Wait(0.05), Do.of("nowhere"))
    whole = {"takes": ("Robot",)}
    with Bench(tiny_world(), _ways(failing, Sequence.of(Wait(0.2), AssertEffects(0.0)), **whole), (Grip, Tap)) as bench:
        running = bench.start("drive", Location="box_a")
        tapping = bench.start("tap")
        bench.until(lambda: tapping.done)

        assert not running.done  # the second way leaves the gripper alone
        bench.until(lambda: running.done)
        assert isinstance(running.result, Success)


def test_a_call_cancelled_while_waiting_for_devices_ends_at_once() -> None:
    ways = (Skill(AT_ONCE, AssertEffects(0.0), driver="fake", takes=("Robot",)),)
    with Bench(tiny_world(), ways, (Grip,)) as bench:
        holding = bench.start("grip")
        bench.advance(0.02)
        waiting = bench.start("drive", Location="box_a")
        bench.advance(0.02)
        waiting.cancel("the plan changed")
        bench.cycle.step()

        assert waiting.done
        assert not holding.done


def test_cancelling_is_reported_as_preempted_and_not_as_an_error() -> None:
    with Bench(tiny_world(), (pretend(DRIVE, Wait(10.0)),)) as bench:
        running = bench.start("drive", Location="box_a")
        bench.advance(0.05)
        running.cancel("the plan changed")
        bench.until(lambda: running.done)

        last = bench.events[-1]
        assert (last.status, last.text) == (Status.PREEMPTED, "the plan changed")


# ------------------------------------------------------------------ loading


def _loading(seconds: float) -> type[Primitive[Any]]:
    class Slow(Grip):
        """Takes its time to load."""

        name: ClassVar[str] = "slow"

        @classmethod
        def load(cls, context: RunContext) -> Any:
            cls.log.append("loads")
            end = time.monotonic() + seconds
            while time.monotonic() < end:
                pass

        def execute(self) -> Execution[Outcome]:
            yield
            return Success()

    return Slow


def test_loading_a_primitive_may_exceed_the_tick_limit() -> None:
    description = replace(FETCH, name="fetch")
    inner = pretend(replace(FETCH, name="grab"), Do.of("slow", gripper=P("Gripper")))
    skills = (inner, pretend(description, Do.of("grab", Base=P("Base"), **{k: P(k) for k in ("Ball", "Box")})))
    with Bench(tiny_world(), skills, (_loading(0.3),), overrun=0.1) as bench:
        running = bench.start("fetch", **TO_BALL)

        assert Grip.log == ["loads"]  # before anything runs
        bench.until(lambda: running.done)
        assert bench.cycle.halted == ""
        assert Grip.log == ["loads"]


def test_loading_that_does_not_end_is_interrupted_and_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("skiros_py.execution.loader._LIMIT", 0.3)
    with Bench(tiny_world(), (), (_loading(60.0),), overrun=0.1) as bench:
        with pytest.raises(Exception, match="the loading of slow held the control cycle"):
            bench.start("slow")
        assert "the loading of slow" in bench.cycle.halted


# ------------------------------------------------------------------ compositions of nothing


@pytest.mark.parametrize("composition", [Sequence, Fallback, Parallel])
def test_an_empty_composition_is_refused(composition: Any) -> None:
    with pytest.raises(DescriptionError, match="at least one part"):
        composition.of()
