"""The life of a primitive: loaded once, started, ticked, ended or cancelled, made up for, reset."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import pytest

from skiros_py.behaviours import Behaviour, Do, Fallback, P, Timeout
from skiros_py.devices.gripper import Gripper, GripperState, GripperTarget
from skiros_py.devices.mobile_base import Base, BaseState, BaseTwist
from skiros_py.errors import ModuleError, UnknownName, UsageError
from skiros_py.execution.monitor import Status
from skiros_py.skills.context import RunContext
from skiros_py.skills.outcome import BROKEN, Failure, Outcome, Success
from skiros_py.skills.parameters import Kind, param
from skiros_py.skills.primitive import Execution, Primitive
from skiros_py.skills.skill import Skill
from skiros_py.testing import Bench, tiny_world
from skiros_py.testing.tiny import AT_LOCATION, DRIVE

lived: list[str] = []
AFTER = replace(DRIVE, pre=(), post=(AT_LOCATION("Robot", "Location"),))


@pytest.fixture(autouse=True)
def _fresh() -> None:
    lived.clear()


class Roll(Primitive["Roll.Params"]):
    """Rolls for a while, and says what is done with it."""

    name: ClassVar[str] = "roll"

    @dataclass(frozen=True, slots=True)
    class Params:
        base: str = param("sk:Base", "The base.", kind=Kind.HARDWARE)
        seconds: float = param("number", "How long.", kind=Kind.OFFLINE, default=0.05, unit="s")
        speed: float = param("number", "How fast.", kind=Kind.CONFIG, default=0.2, unit="m/s")

    @classmethod
    def load(cls, context: RunContext) -> Any:
        lived.append("load")
        return [cls.name]

    @classmethod
    def reset(cls, context: RunContext, loaded: Any) -> Any:
        lived.append("reset")
        return [*loaded, "again"]

    def start(self) -> Failure | None:
        lived.append("start")
        return None

    def execute(self) -> Execution[Outcome]:
        end = self.context.now + self.params.seconds
        while self.context.now < end:
            Base(self.context.board, self.params.base).command(BaseTwist(self.params.speed, 0.0))
            yield
        lived.append("done")
        return Success(str(self.loaded))

    def stop(self) -> None:
        lived.append("stop")

    def recover(self) -> Execution[None]:
        for _ in range(3):
            lived.append("recover")
            yield


def bench_of(
    *primitives: type[Primitive[Any]], body: Behaviour | None = None, config: dict[str, Any] | None = None
) -> Bench:
    skills = () if body is None else (Skill(AFTER, body, driver="fake"),)
    return Bench(tiny_world(), skills, primitives, config=config)


def story(bench: Bench, module: str) -> list[Status]:
    return [event.status for event in bench.events if event.module == module]


# ------------------------------------------------------------------ loading


def test_a_primitive_is_loaded_once_per_manager_and_reused_by_each_run() -> None:
    with bench_of(Roll) as bench:
        assert bench.run("roll") == bench.run("roll") == Success("['roll']")

    assert lived.count("load") == 1
    assert lived == ["load", *("start", "done") * 2]


def test_each_manager_loads_its_own_primitive() -> None:
    with Bench(tiny_world(robots=2), (), (Roll,)) as bench:
        bench.run("roll", base="base_1")
        bench.managers["base_2"].start("roll", {})
        bench.advance(0.1)

    assert lived.count("load") == 2


def test_a_primitive_that_fails_to_load_fails_its_run_and_is_loaded_again_for_the_next() -> None:
    class Moody(Roll):
        tries: ClassVar[list[int]] = []

        @classmethod
        def load(cls, context: RunContext) -> Any:
            cls.tries.append(1)
            if len(cls.tries) == 1:
                raise SystemExit(3)
            return "at last"

    with bench_of(Moody) as bench:
        assert bench.run("roll") == Failure("roll did not load: it tried to end the program: sys.exit(3)", BROKEN)
        assert bench.run("roll") == Success("at last")

        failed = next(event for event in bench.events if event.status is Status.ERROR)
        assert (failed.module, failed.text) == ("roll", "roll did not load: it tried to end the program: sys.exit(3)")


def test_a_configuration_is_fixed_when_it_is_loaded() -> None:
    with bench_of(Roll, config={"roll.speed": 0.4}) as bench:
        bench.run("roll")

        assert bench.cycle.board.snapshot.state("base_1", BaseState).pose.position[0] == pytest.approx(
            0.4 * 0.05, rel=0.2
        )


def test_a_configuration_cannot_be_given_at_a_call() -> None:
    with bench_of(Roll) as bench:
        outcome = bench.run("roll", speed=9.0)

    assert outcome == Failure("roll: parameter speed is fixed when the module is loaded: it cannot be given at a call")


@pytest.mark.parametrize(
    ("config", "told"),
    [
        ({"roll.sped": 1.0}, "unknown configuration parameter 'sped' of roll"),
        ({"roll.speed": "fast"}, "speed"),
        ({"rol.speed": 1.0}, "unknown primitive 'rol' in the configuration. Did you mean 'roll'?"),
        ({"roll": 1.0}, "unknown configuration parameter '' of roll"),
    ],
)
def test_a_wrong_configuration_is_refused_by_name_before_anything_runs(config: dict[str, Any], told: str) -> None:
    with pytest.raises(UsageError, match=told):
        bench_of(Roll, config=config)


# ------------------------------------------------------------------ start, stop, recover, reset


def test_a_primitive_that_fails_in_start_does_nothing_and_gives_its_reason() -> None:
    class Wary(Roll):
        def start(self) -> Failure | None:
            return Failure("the battery is low", -7)

    with bench_of(Wary) as bench:
        assert bench.run("roll") == Failure("the battery is low", -7)
        assert story(bench, "roll") == [Status.STARTED, Status.ERROR]
        assert bench.cycle.board.snapshot.state("base_1", BaseState).pose.position[0] == 0.0

    assert lived == ["load"]


def test_a_stop_is_reported_at_once_and_no_events_follow() -> None:
    with bench_of(Roll) as bench:
        running = bench.start("roll", seconds=9.0)
        bench.advance(0.05)
        running.stop()

        assert lived == ["load", "start", "stop"]
        bench.advance(0.5)
        assert lived == ["load", "start", "stop"]
        assert story(bench, "roll") == [Status.STARTED, Status.RUNNING, Status.PREEMPTED]


def test_a_primitive_stopped_before_its_first_tick_is_never_started() -> None:
    with bench_of(Roll) as bench:
        running = bench.start("roll")
        running.stop()
        bench.advance(0.1)

        assert running.result == Failure("roll was stopped")
        assert bench.run("roll") == Success("['roll']")
    assert lived == ["load", "start", "done"]


def test_a_run_cancelled_by_a_timeout_recovers_before_the_skill_continues() -> None:
    body = Fallback.of(Timeout(Do.of("roll", seconds=9.0), 0.05), Do.of("roll", seconds=0.01))
    with bench_of(Roll, body=body) as bench:
        bench.run("drive", Location="floor")

    assert lived == ["load", "start", "stop", *["recover"] * 3, "start", "done"]


def test_endless_recovery_is_ended_and_the_next_run_gets_the_devices() -> None:
    class Endless(Roll):
        name: ClassVar[str] = "endless"

        def recover(self) -> Execution[None]:
            while True:
                Base(self.context.board, self.params.base).command(BaseTwist(-0.2, 0.0))
                yield

    body = Fallback.of(Timeout(Do.of("endless", seconds=9.0), 0.05), Do.of("roll"))
    with bench_of(Roll, Endless, body=body) as bench:
        took = bench.time
        bench.run("drive", Location="floor")
        took = bench.time - took

    assert lived[-1] == "done"
    assert 20.0 < took < 21.0


def test_the_last_command_of_a_recovery_is_sent() -> None:
    class Opens(Roll):
        @dataclass(frozen=True, slots=True)
        class Params:
            gripper: str = param("sk:Gripper", "The gripper.", kind=Kind.HARDWARE)

        def execute(self) -> Execution[Outcome]:
            while True:
                Gripper(self.context.board, self.params.gripper).command(GripperTarget(0.01, 5.0))
                yield

        def recover(self) -> Execution[None]:
            yield
            Gripper(self.context.board, self.params.gripper).command(GripperTarget(0.07, 5.0))

    gripper = replace(DRIVE.params[0], key="Gripper", type="sk:Gripper")
    skill = Skill(replace(AFTER, params=(*AFTER.params, gripper)), Timeout(Do.of("roll", gripper=P("Gripper")), 0.05))
    with Bench(tiny_world(), (skill,), (Opens,), driver="any") as bench:
        bench.run("drive", Location="floor", Gripper="gripper_1")

        bench.advance(0.05)
        assert bench.cycle.board.snapshot.state("gripper_1", GripperState).gap == 0.07


def test_a_reset_prepares_a_loaded_primitive_for_its_next_run() -> None:
    with bench_of(Roll) as bench:
        manager = bench.managers["base_1"]
        manager.reset("roll")  # never loaded: nothing to do
        bench.run("roll")
        manager.reset("roll")

        assert bench.run("roll") == Success("['roll', 'again']")
    assert lived.count("load") == lived.count("reset") == 1


def test_resetting_a_running_or_unknown_module_is_refused() -> None:
    with bench_of(Roll) as bench:
        bench.start("roll")
        with pytest.raises(UsageError, match="roll of base_1 is running: stop it first"):
            bench.managers["base_1"].reset("roll")
        with pytest.raises(UnknownName, match="unknown module 'rol'"):
            bench.managers["base_1"].reset("rol")


def test_a_module_whose_reset_raises_is_reported_and_loaded_again() -> None:
    class Stuck(Roll):
        @classmethod
        def reset(cls, context: RunContext, loaded: Any) -> Any:
            raise ValueError("no such gear")

    with bench_of(Stuck) as bench:
        bench.run("roll")
        with pytest.raises(ModuleError, match="roll, when it was reset, broke: ValueError: no such gear"):
            bench.managers["base_1"].reset("roll")

        assert bench.run("roll") == Success("['roll']")
    assert lived.count("load") == 2


# ------------------------------------------------------------------ progress


def test_progress_is_reported_under_the_module_name_and_a_negative_code_does_not_end_the_run() -> None:
    class Tells(Roll):
        def execute(self) -> Execution[Outcome]:
            self.progress(1, "half way")
            yield
            self.progress(-4, "something rattles")
            yield
            return Success("there")

    with bench_of(Tells) as bench:
        assert bench.run("roll") == Success("there")

        assert [(e.status, e.code, e.text) for e in bench.events][1:] == [
            (Status.RUNNING, 1, "half way"),
            (Status.RUNNING, -4, "something rattles"),
            (Status.TERMINATED, 1, "there"),
        ]


# ------------------------------------------------------------------ calling others


class Calls(Primitive["Calls.Params"]):
    """Calls others as the test says."""

    name: ClassVar[str] = "calls"
    does: ClassVar[Callable[[Calls], Execution[Outcome]]]

    @dataclass(frozen=True, slots=True)
    class Params:
        base: str = param("sk:Base", "The base.", kind=Kind.HARDWARE)

    def execute(self) -> Execution[Outcome]:
        return (yield from type(self).does(self))

    def recover(self) -> Execution[None]:
        lived.append("the caller recovers")
        yield


def calling(does: Callable[[Calls], Execution[Outcome]]) -> type[Calls]:
    return type("Calls", (Calls,), {"does": staticmethod(does)})


@pytest.fixture
def calls_for_long() -> Iterator[Bench]:
    def does(caller: Calls) -> Execution[Outcome]:
        return (yield from caller.call("roll", seconds=9.0))

    with bench_of(calling(does), Roll, body=Do.of("calls")) as bench:
        yield bench


def test_a_called_module_uses_the_device_of_its_caller_and_returns_its_outcome() -> None:
    def does(caller: Calls) -> Execution[Outcome]:
        outcome = yield from caller.call("roll", base=caller.params.base)
        return Success(f"heard {outcome}")

    with bench_of(calling(does), Roll) as bench:
        assert bench.run("calls") == Success("heard Success(message=\"['roll']\")")
        assert [(e.module, e.status, e.caller) for e in bench.events] == [
            ("calls", Status.STARTED, ""),
            ("roll", Status.STARTED, "calls"),
            ("roll", Status.TERMINATED, "calls"),
            ("calls", Status.TERMINATED, ""),
        ]


def test_a_called_module_gets_no_device_that_its_caller_does_not_have() -> None:
    class Bare(Calls):
        @dataclass(frozen=True, slots=True)
        class Params:
            pass

        @staticmethod
        def does(caller: Calls) -> Execution[Outcome]:
            return (yield from caller.call("roll"))

    with bench_of(Bare, Roll) as bench:
        outcome = bench.run("calls")

    assert isinstance(outcome, Failure)
    assert "roll needs base_1, but calls has none: declare what is missing as a hardware parameter" in outcome.reason


def test_joined_calls_run_in_parallel_but_one_after_the_other_on_one_device() -> None:
    def does(caller: Calls) -> Execution[Outcome]:
        yield from caller.join(caller.call("roll", seconds=0.1), caller.call("roll", seconds=0.1))
        return Success()

    with bench_of(calling(does), Roll) as bench:
        bench.run("calls")

        assert bench.time == pytest.approx(0.2, abs=0.03)


def test_stopping_the_caller_stops_the_called_module_and_each_reports_one_end(calls_for_long: Bench) -> None:
    running = calls_for_long.managers["base_1"].start("calls", {})
    calls_for_long.advance(0.05)
    running.stop()
    calls_for_long.advance(0.05)

    assert lived == ["load", "start", "stop"]
    assert story(calls_for_long, "roll") == [Status.STARTED, Status.PREEMPTED]
    assert story(calls_for_long, "calls") == [Status.STARTED, Status.RUNNING, Status.PREEMPTED]


def test_a_call_cancelled_with_its_caller_recovers_before_its_devices_are_released(
    calls_for_long: Bench,
) -> None:
    running = calls_for_long.start("drive", Location="box_a")
    calls_for_long.advance(0.05)
    running.cancel("the world changed")
    calls_for_long.until(lambda: running.done)

    assert lived == ["load", "start", "stop", *["recover"] * 3, "the caller recovers"]


def test_a_call_cancelled_by_its_author_recovers_before_the_next_call() -> None:
    def does(caller: Calls) -> Execution[Outcome]:
        first = caller.call("roll", seconds=9.0)
        for _ in range(5):
            next(first)
            yield
        first.close()
        return (yield from caller.call("roll"))

    with bench_of(calling(does), Roll) as bench:
        running = bench.start("calls")
        bench.until(lambda: running.done, limit=1.0)

        assert isinstance(running.result, Success)
    assert lived == ["load", "start", "stop", *["recover"] * 3, "start", "done"]


def test_a_call_left_open_recovers_before_its_caller_ends() -> None:
    def does(caller: Calls) -> Execution[Outcome]:
        open_ = caller.call("roll", seconds=9.0)
        next(open_)
        yield
        open_.close()
        return Success()

    with bench_of(calling(does), Roll) as bench:
        bench.run("calls")

    assert lived == ["load", "start", "stop", *["recover"] * 3]


def test_a_caller_that_raises_cancels_its_calls_which_recover() -> None:
    def breaks(caller: Calls) -> Execution[Outcome]:
        yield
        raise ValueError("no such gear")

    def does(caller: Calls) -> Execution[Outcome]:
        yield from caller.join(caller.call("roll", seconds=9.0), breaks(caller))
        return Success()

    with bench_of(calling(does), Roll) as bench:
        assert bench.run("calls") == Failure("calls broke: ValueError: no such gear", BROKEN)
        assert story(bench, "roll") == [Status.STARTED, Status.PREEMPTED]
        assert bench.cycle.board.still
    assert lived == ["load", "start", "stop", *["recover"] * 3]


def test_calling_an_unknown_module_fails_the_caller_and_names_the_module() -> None:
    def does(caller: Calls) -> Execution[Outcome]:
        return (yield from caller.call("rol"))

    with bench_of(calling(does), Roll) as bench:
        outcome = bench.run("calls")

    assert isinstance(outcome, Failure)
    assert "unknown module 'rol' of base_1. Did you mean 'roll'?" in outcome.reason


def test_endlessly_recursive_primitive_calls_are_ended() -> None:
    def does(caller: Calls) -> Execution[Outcome]:
        return (yield from caller.call("calls"))

    with bench_of(calling(does)) as bench:
        assert isinstance(bench.run("calls"), Failure)
        assert bench.cycle.board.still


# ------------------------------------------------------------------ what breaks


def test_no_command_of_a_module_is_sent_after_it_raised() -> None:
    class Breaks(Roll):
        def execute(self) -> Execution[Outcome]:
            yield
            Base(self.context.board, self.params.base).command(BaseTwist(0.5, 0.0))
            raise ValueError("no such gear")

    with bench_of(Breaks) as bench:
        assert bench.run("roll") == Failure("roll broke: ValueError: no such gear", BROKEN)
        bench.advance(0.1)
        assert bench.cycle.board.snapshot.state("base_1", BaseState).pose.position[0] == 0.0


@pytest.mark.parametrize("where", ["load", "start", "execute", "close"])
@pytest.mark.parametrize("kind", [KeyboardInterrupt, SystemExit, GeneratorExit, BaseException])
def test_what_a_primitive_raises_ends_it_alone_where_the_command_handles_interrupts_itself(
    where: str, kind: type[BaseException], monkeypatch: pytest.MonkeyPatch
) -> None:
    class Wild(Roll):
        @classmethod
        def load(cls, context: RunContext) -> Any:
            if where == "load":
                raise kind
            return []

        def start(self) -> Failure | None:
            if where == "start":
                raise kind
            return None

        def execute(self) -> Execution[Outcome]:
            try:
                yield
                if where == "execute":
                    raise kind
            finally:
                if where == "close":
                    raise kind
            return Success()

    monkeypatch.setattr(signal, "getsignal", lambda _: lambda *_: None)
    with bench_of(Wild) as bench:
        ended = bench.run("roll")

        assert isinstance(ended, Failure)
        assert ended.code == BROKEN
        assert bench.cycle.step() is None
