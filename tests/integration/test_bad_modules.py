"""Modules that break, never end or hold the cycle are contained and named, the robot halts, and all else goes on."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from skiros_py.behaviours import Do, P, Parallel, Timeout
from skiros_py.devices.mobile_base import Base, BaseTwist
from skiros_py.errors import UsageError
from skiros_py.execution.monitor import Status
from skiros_py.skills.outcome import Failure, Outcome, Success
from skiros_py.skills.primitive import Execution
from skiros_py.skills.skill import Skill
from skiros_py.testing import (
    Bench,
    run_primitive,
    run_skill,
    tiny_world,
)
from skiros_py.testing.tiny import DRIVE

from .bad import Bad, Behaviour, Moving, OwnBase, assert_others_go_on, bad, halted, raising, returning, yielding


def leaving(bad: Bad) -> Execution[Outcome]:
    yield
    sys.exit(7)


def recursing(bad: Bad) -> Execution[Outcome]:
    yield
    return recursing_deeper(1)


def recursing_deeper(depth: int) -> Outcome:
    return recursing_deeper(depth + 1)


# ------------------------------------------------------------------ while they run


@pytest.mark.parametrize(
    ("behaviour", "told"),
    [
        (raising(ValueError("no such gear")), "ValueError: no such gear"),
        (raising(OwnBase("mine")), "OwnBase: mine"),
        (raising(GeneratorExit("pretends to be closed")), "GeneratorExit"),
        (raising(StopIteration(5)), "StopIteration"),
        (raising(MemoryError()), "MemoryError"),
        (leaving, "sys.exit(7)"),
        (recursing, "RecursionError"),
        (returning(None), "None"),
        (returning(42), "42"),
        (returning("done"), "'done'"),
        (returning(Success), "Success"),
        (yielding(42), "42"),
        (yielding(Success("done")), "Success"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_an_exception_in_a_run_is_a_failure_of_that_module(behaviour: Behaviour, told: str) -> None:
    with Bench(tiny_world(), (), [bad(behaviour), Moving]) as bench:
        outcome = bench.run("bad", base="base_1")

        assert isinstance(outcome, Failure)
        assert "bad" in outcome.reason
        assert told in outcome.reason
        assert outcome.code < 0
        errors = [event for event in bench.events if event.status is Status.ERROR]
        assert [(event.module, event.text) for event in errors] == [("bad", outcome.reason)]
        assert_others_go_on(bench)


def test_the_log_contains_the_traceback_of_an_exception(caplog: pytest.LogCaptureFixture) -> None:
    run_primitive(bad(raising(ValueError("no such gear"))), tiny_world())

    assert "no such gear" in caplog.text
    assert "Traceback" in caplog.text
    assert "bad.py" in caplog.text


class BreaksWhenMade(Moving):
    """Breaks in its constructor."""

    name = "bad"

    def __init__(self, *arguments: Any) -> None:
        raise RuntimeError("cannot be made")


class BreaksWhenLoaded(Moving):
    """Breaks when it is loaded."""

    name = "bad"

    @classmethod
    def load(cls, context: Any) -> Any:
        raise RuntimeError("cannot be loaded")


class LeavesWhenLoaded(Moving):
    """Ends the program when it is loaded."""

    name = "bad"

    @classmethod
    def load(cls, context: Any) -> Any:
        sys.exit("cannot be loaded")


class BreaksWhenStarted(Moving):
    """Breaks when it is started."""

    name = "bad"

    def start(self) -> Failure | None:
        raise RuntimeError("cannot be started")


class RefusesWithNonsense(Moving):
    """Says something that is no failure when it is started."""

    name = "bad"

    def start(self) -> Any:
        return "cannot be started"


class NeverYields(Moving):
    """Returns at once instead of running."""

    name = "bad"

    def execute(self) -> Any:
        return Success("cannot be right")


class ReturnsNothing(Moving):
    """Its execution is no generator."""

    name = "bad"

    def execute(self) -> Any:
        return None


class BreaksBeforeItYields(Moving):
    """Its execution is no generator and breaks."""

    name = "bad"

    def execute(self) -> Any:
        raise RuntimeError("cannot be run")


@pytest.mark.parametrize(
    "primitive",
    [
        BreaksWhenMade,
        BreaksWhenLoaded,
        LeavesWhenLoaded,
        BreaksWhenStarted,
        RefusesWithNonsense,
        NeverYields,
        ReturnsNothing,
        BreaksBeforeItYields,
    ],
)
def test_an_exception_before_the_run_is_a_failure_of_that_module(primitive: type[Moving]) -> None:
    with Bench(tiny_world(), (), [primitive, Moving]) as bench:
        outcome = bench.run("bad", base="base_1")

        assert isinstance(outcome, Failure)
        assert "bad" in outcome.reason
        assert_others_go_on(bench)


def test_a_module_that_raises_inside_a_skill_fails_the_skill_which_names_the_module() -> None:
    skill = Skill(DRIVE, Do.of("bad", base=P("Base")))

    trial = run_skill(skill, tiny_world(), primitives=[bad(raising(ValueError("no such gear")))], Location="box_a")

    assert "bad" in trial.reason
    assert "no such gear" in trial.reason
    assert [verdict.holds for verdict in trial.verdicts] == [False]


def test_an_exception_in_one_branch_stops_the_other() -> None:
    other = type("Other", (Moving,), {"name": "other", "__doc__": "-", "execute": lambda self: self.drive(1e9)})
    both = Parallel.of(Do.of("bad", base=P("Base")), Do.of("other", base="base_2"))
    world = tiny_world(robots=2)
    with Bench(world, (Skill(DRIVE, both),), [bad(raising(ValueError("no"))), other], driver="any") as bench:
        outcome = bench.run("drive", Base="base_1", Location="box_a")

        assert isinstance(outcome, Failure)
        bench.advance(0.1)
        assert bench.cycle.board.still


# ------------------------------------------------------------------ without end


def test_an_endless_generator_is_cancelled_by_a_timeout() -> None:
    skill = Skill(DRIVE, Timeout(Do.of("bad", base=P("Base")), 1.0))
    with Bench(tiny_world(), (skill,), [bad(yielding(None)), Moving], driver="any") as bench:
        outcome = bench.run("drive", Location="box_a")

        assert isinstance(outcome, Failure)
        assert "1 s" in outcome.reason
        assert bench.time == pytest.approx(1.0, abs=0.1)
        assert_others_go_on(bench)


def test_an_endless_generator_is_stopped_at_once() -> None:
    with Bench(tiny_world(), (), [bad(yielding(None)), Moving]) as bench:
        running = bench.start("bad", base="base_1")
        bench.advance(0.3)
        running.stop()

        bench.until(lambda: running.done, limit=0.1)
        assert "stopped" in str(running.result)
        assert_others_go_on(bench)


def yields_when_closed(bad: Bad) -> Execution[Outcome]:
    while True:
        try:
            yield from bad.drive(1e9)
        except GeneratorExit:
            yield


def yields_once_when_closed(bad: Bad) -> Execution[Outcome]:
    try:
        yield from bad.drive(1e9)
    finally:
        yield


def drives_when_closed(bad: Bad) -> Execution[Outcome]:
    base = Base(bad.context.board, bad.params.base)
    try:
        yield from bad.drive(1e9)
    finally:
        base.command(BaseTwist(0.5, 0.0))


def breaks_when_closed(bad: Bad) -> Execution[Outcome]:
    try:
        yield from bad.drive(1e9)
    finally:
        raise RuntimeError("cannot end")


def leaves_when_closed(bad: Bad) -> Execution[Outcome]:
    try:
        yield from bad.drive(1e9)
    finally:
        sys.exit(9)


def returns_when_closed(bad: Bad) -> Execution[Outcome]:
    try:
        yield from bad.drive(1e9)
    except GeneratorExit:
        return Success("as if nothing were")
    return Success()


CLOSING_BADLY = [
    yields_when_closed,
    yields_once_when_closed,
    drives_when_closed,
    breaks_when_closed,
    leaves_when_closed,
    returns_when_closed,
]


@pytest.mark.parametrize("behaviour", CLOSING_BADLY)
def test_the_robot_halts_however_a_module_reacts_to_a_stop(behaviour: Behaviour) -> None:
    with Bench(tiny_world(), (), [bad(behaviour), Moving]) as bench:
        running = bench.start("bad", base="base_1")
        bench.advance(0.3)
        running.stop()

        bench.until(lambda: running.done, limit=0.1)
        assert isinstance(running.result, Failure)
        assert_others_go_on(bench)


@pytest.mark.parametrize("behaviour", CLOSING_BADLY)
def test_a_cancelled_skill_ends_and_the_robot_halts_however_the_skill_reacts(behaviour: Behaviour) -> None:
    skill = Skill(DRIVE, Do.of("bad", base=P("Base")))
    with Bench(tiny_world(), (skill,), [bad(behaviour), Moving], driver="any") as bench:
        outcome = bench.run("drive", Location="box_a", cancel=lambda: "the world changed" if bench.time > 0.3 else "")

        assert isinstance(outcome, Failure)
        assert bench.time < 1.0
        assert_others_go_on(bench)


class StopsBadly(Bad):
    """Breaks in its tidying up and in its recovery."""

    behaviour = staticmethod(yielding(None))

    def stop(self) -> None:
        raise RuntimeError("cannot tidy up")

    def recover(self) -> Execution[None]:
        yield
        raise OwnBase("cannot recover")


class RecoversForEver(Bad):
    """Its recovery never ends."""

    behaviour = staticmethod(yielding(None))

    def recover(self) -> Execution[None]:
        yield from self.drive(1e9)


class RecoversNonsense(Bad):
    """Its recovery is no generator."""

    behaviour = staticmethod(yielding(None))

    def recover(self) -> Any:
        return None


@pytest.mark.parametrize("primitive", [StopsBadly, RecoversForEver, RecoversNonsense])
def test_a_faulty_recovery_is_ended_and_the_robot_halts(primitive: type[Bad]) -> None:
    skill = Skill(DRIVE, Do.of("bad", base=P("Base")))
    with Bench(tiny_world(), (skill,), [primitive, Moving], driver="any") as bench:
        running = bench.start("drive", Location="box_a")
        bench.advance(0.3)
        running.cancel("the world changed")

        bench.until(lambda: running.done, limit=30.0)
        assert "the world changed" in str(running.result)
        assert_others_go_on(bench)


# ------------------------------------------------------------------ holding the control cycle


def spins(bad: Bad) -> Execution[Outcome]:
    yield
    while True:
        pass


def spins_and_catches_exceptions(bad: Bad) -> Execution[Outcome]:
    yield
    while True:
        try:
            while True:
                pass
        except Exception:  # noqa: BLE001 - what it is there for
            pass


def spins_and_catches_everything_for_a_while(bad: Bad) -> Execution[Outcome]:
    yield
    for _ in range(3):
        try:
            while True:
                pass
        except BaseException:  # noqa: BLE001 - what it is there for
            pass
    return Success("stubborn")


def sleeps(bad: Bad) -> Execution[Outcome]:
    yield
    time.sleep(1.0)
    return Success("slept well")


@pytest.mark.parametrize(
    "behaviour", [spins, spins_and_catches_exceptions, spins_and_catches_everything_for_a_while, sleeps]
)
def test_code_that_blocks_the_cycle_is_interrupted_and_named_and_the_robot_halts_until_reset(
    behaviour: Behaviour,
) -> None:
    with Bench(tiny_world(), (), [bad(behaviour), Moving], overrun=0.2) as bench:
        outcome = bench.run("bad", base="base_1")

        assert isinstance(outcome, Failure)
        assert "bad" in outcome.reason
        assert "held the control cycle" in outcome.reason
        assert halted(bench)
        with pytest.raises(UsageError, match="reset"):
            bench.start("moving", base="base_1")
        bench.cycle.reset()
        assert bench.run("moving", base="base_1") == Success("drove")


HANGING = """
import ctypes, threading, time
from skiros_py.testing import Bench, tiny_world
from bad import Bad, bad

def hangs(bad):
    yield
    ctypes.CDLL(None).sleep(3600)

bench = Bench(tiny_world(), (), [bad(hangs)], overrun=0.2)
with bench:
    bench.watchdog._patience = 0.5
    thread = threading.Thread(target=lambda: bench.run("bad", base="base_1"), daemon=True)
    thread.start()
    deadline = time.monotonic() + 20.0
    while not bench.managers["base_1"].lost and time.monotonic() < deadline:
        time.sleep(0.05)
    print("lost:", bench.managers["base_1"].lost)
    print("offers:", dict(bench.managers["base_1"].descriptions))
    print("others:", bench.managers["arm_1"].lost or "fine")
    with bench.world.transaction("anna", "by hand") as tx:
        tx.place("ball_1", "sk:in", "box_b")
    print("world:", bench.world.objects("ball_1", "sk:in"), flush=True)
    import os
    os._exit(0)  # whose call never returns cannot be joined; what is printed has to be flushed before
"""


def test_a_call_into_c_that_never_returns_loses_its_manager_and_the_world_stays_usable(tmp_path: Path) -> None:
    program = f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})\n{HANGING}"

    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False, timeout=60, cwd=tmp_path
    )

    assert done.returncode == 0, done.stderr
    lines = dict(line.split(": ", 1) for line in done.stdout.splitlines())
    assert "bad" in lines["lost"]
    assert lines["offers"] == "{}"
    assert lines["others"] == "fine"
    assert lines["world"] == "('box_b',)"


@pytest.mark.parametrize("where", ["__init__", "start", "stop", "recover"])
def test_code_that_blocks_the_cycle_outside_execute_is_interrupted_too(where: str) -> None:
    def hold(self: Any, *arguments: Any) -> None:
        while True:
            pass

    primitive = type("Holding", (bad(yielding(None)),), {where: hold, "__doc__": "-"})
    skill = Skill(DRIVE, Do.of("bad", base=P("Base")))
    with Bench(tiny_world(), (skill,), [primitive, Moving], driver="any", overrun=0.2) as bench:
        running = bench.start("drive", Location="box_a")
        bench.advance(0.3)
        running.cancel("the world changed")
        bench.until(lambda: running.done, limit=30.0)

        assert "bad (of drive of base_1) held the control cycle" in str(running.result)
        assert halted(bench)
        bench.cycle.reset()
        assert bench.run("moving", base="base_1") == Success("drove")
